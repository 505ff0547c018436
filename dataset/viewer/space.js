"use strict";
// The scene in three dimensions (WebGL 2): surfaces, boxes, cameras, points. The world is z up, in metres.

const multiply = (a, b) => {  // column by column
  const c = new Float32Array(16);
  for (let i = 0; i < 4; i++) for (let j = 0; j < 4; j++)
    for (let k = 0; k < 4; k++) c[4 * j + i] += a[4 * k + i] * b[4 * j + k];
  return c;
};
const transposed = (m) => Float32Array.from({length: 16}, (_, i) => m[4 * (i % 4) + (i >> 2)]);
const apply = (m, [x, y, z]) => [0, 1, 2, 3].map((i) => m[i] * x + m[4 + i] * y + m[8 + i] * z + m[12 + i]);
const minus = (a, b) => a.map((v, i) => v - b[i]);
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const unit = (a) => a.map((v) => v / (Math.hypot(...a) || 1));
const IDENTITY = Float32Array.from([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);

// Inverse of a rigid transform, given row by row, as a matrix of columns.
function viewOf(pose) {
  const R = (i, j) => pose[4 * j + i], t = [pose[3], pose[7], pose[11]], m = new Float32Array(16);
  for (let i = 0; i < 3; i++) {
    for (let j = 0; j < 3; j++) m[4 * j + i] = R(i, j);
    m[12 + i] = -(R(i, 0) * t[0] + R(i, 1) * t[1] + R(i, 2) * t[2]);
  }
  m[15] = 1;
  return m;
}

// The projection of a pinhole camera with OpenCV axes into a canvas of another shape, fitted inside.
function pinhole(K, width, height, canvas, near, far) {
  const fit = Math.min(canvas.width / width, canvas.height / height), m = new Float32Array(16);
  const sx = 2 * fit / canvas.width, sy = 2 * fit / canvas.height;
  m[0] = sx * K[0][0];
  m[5] = -sy * K[1][1];
  m[8] = sx * (K[0][2] - (width - 1) / 2);
  m[9] = -sy * (K[1][2] - (height - 1) / 2);
  m[10] = (far + near) / (far - near);
  m[11] = 1;
  m[14] = -2 * far * near / (far - near);
  return m;
}

const SURFACE = [`#version 300 es
uniform mat4 world, camera; uniform vec3 eye; in vec3 place; in vec3 normal; out vec3 n; out vec3 v;
void main() { vec4 p = world * vec4(place, 1.0); n = mat3(world) * normal; v = eye - p.xyz; gl_Position = camera * p; }`,
`#version 300 es
precision highp float; uniform vec4 colour; uniform float glass; in vec3 n; in vec3 v; out vec4 shown;
void main() {
  vec3 unit = normalize(n), sight = normalize(v); float facing = abs(dot(unit, sight));
  float light = 0.35 + 0.45 * facing + 0.2 * max(0.0, unit.z * (dot(unit, sight) < 0.0 ? -1.0 : 1.0));
  float alpha = mix(colour.a, min(1.0, colour.a + 0.75), pow(1.0 - facing, 2.5));
  float spark = glass * pow(max(0.0, dot(reflect(-sight, unit), normalize(vec3(0.4, 0.3, 1.0)))), 40.0);
  shown = vec4(mix(colour.rgb * light, vec3(1.0), 0.7 * spark), mix(colour.a, alpha, glass) + 0.5 * spark);
}`];
const POINT = [`#version 300 es
uniform mat4 camera; uniform float size; in vec3 place; in vec3 paint; out vec3 c;
void main() { c = paint; gl_Position = camera * vec4(place, 1.0); gl_PointSize = size; }`,
`#version 300 es
precision highp float; in vec3 c; out vec4 shown;
void main() { shown = vec4(c, 1.0); }`];

function program(gl, [vertex, fragment]) {
  const made = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    gl.attachShader(made, shader);
  }
  gl.linkProgram(made);
  return made;
}

function buffered(gl, used, arrays, count, indices) {
  const vao = gl.createVertexArray();
  gl.bindVertexArray(vao);
  for (const [name, data, kind, scaled] of arrays) {
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
    const place = gl.getAttribLocation(used, name);
    if (place < 0) continue;
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, 3, kind, scaled, 0, 0);
  }
  if (indices) {
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, indices, gl.STATIC_DRAW);
  }
  gl.bindVertexArray(null);
  return {vao, count};
}

// Normals of vertices: sums of the triangles' normals times their areas. Triangles of a crease keep their own.
function shaded(vertices, faces, smooth) {
  const corner = (f) => [vertices[3 * f], vertices[3 * f + 1], vertices[3 * f + 2]];
  const sums = new Float32Array(vertices.length), count = faces.length, place = new Float32Array(3 * count);
  const normal = new Float32Array(3 * count), own = new Float32Array(count);
  for (let i = 0; i < count; i += 3) {
    const [a, b, c] = [0, 1, 2].map((k) => corner(faces[i + k])), n = cross(minus(b, a), minus(c, a));
    own.set(n, i);
    for (let k = 0; k < 3; k++) for (let x = 0; x < 3; x++) sums[3 * faces[i + k] + x] += n[x];
  }
  for (let i = 0; i < count; i++) {
    place.set(corner(faces[i]), 3 * i);
    const first = i - i % 3, flat = unit([own[first], own[first + 1], own[first + 2]]);
    const mean = unit([0, 1, 2].map((x) => sums[3 * faces[i] + x]));
    normal.set(dot(flat, mean) > smooth ? mean : flat, 3 * i);
  }
  return {place, normal, count};
}

class Space {
  constructor(canvas, onchange) {
    this.canvas = canvas;
    this.gl = canvas.getContext("webgl2", {antialias: true, preserveDrawingBuffer: true});
    this.onchange = onchange;
    this.target = [0, 0, 0.08];
    [this.yaw, this.pitch, this.distance, this.camera] = [-2.2, 0.55, 1.3, null];
    if (!this.gl) return;
    this.surface = program(this.gl, SURFACE);
    this.point = program(this.gl, POINT);
    this.surfaces = [];
    this.groups = {};
    this.listen();
  }

  listen() {
    const {canvas} = this;
    let last = null;
    canvas.addEventListener("pointerdown", (event) => {
      last = event;
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointerup", () => (last = null));
    canvas.addEventListener("pointermove", (event) => {
      if (!last) return;
      const x = event.clientX - last.clientX, y = event.clientY - last.clientY;
      last = event;
      this.camera = null;
      if (event.shiftKey || event.buttons & 6) {
        const [right, up] = this.axes(), step = this.distance / canvas.clientHeight;
        this.target = this.target.map((v, i) => v - step * (x * right[i] - y * up[i]));
      } else {
        this.yaw -= 0.008 * x;
        this.pitch = Math.min(1.55, Math.max(-1.55, this.pitch + 0.008 * y));
      }
      this.onchange();
    });
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.camera = null;
      this.distance = Math.min(60, Math.max(0.03, this.distance * Math.exp(0.001 * event.deltaY)));
      this.onchange();
    }, {passive: false});
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  }

  forward() {
    return [-Math.cos(this.yaw) * Math.cos(this.pitch), -Math.sin(this.yaw) * Math.cos(this.pitch), -Math.sin(this.pitch)];
  }

  axes() {
    const ahead = this.forward(), right = unit(cross(ahead, [0, 0, 1]));
    return [right, cross(right, ahead), ahead];
  }

  // The matrix that takes the world to clip space, and the eye.
  sight() {
    const near = 0.01, far = 80;
    if (this.camera) {
      const {K, pose, width, height} = this.camera;
      return [multiply(pinhole(K, width, height, this.canvas, near, far), viewOf(pose)), [pose[3], pose[7], pose[11]]];
    }
    const [right, up, ahead] = this.axes(), eye = this.target.map((v, i) => v - this.distance * ahead[i]);
    const pose = [0, 1, 2].flatMap((i) => [right[i], -up[i], ahead[i], eye[i]]).concat([0, 0, 0, 1]);
    const focal = 1.1 * this.canvas.height, {width, height} = this.canvas;
    const K = [[focal, 0, (width - 1) / 2], [0, focal, (height - 1) / 2]];
    return [multiply(pinhole(K, width, height, this.canvas, near, far), viewOf(pose)), eye];
  }

  async setBodies(bodies, colours) {
    this.surfaces = [];
    for (const body of bodies)
      for (const one of body.surfaces) {
        const steps = await values(one.vertices), faces = await values(one.faces), n = steps.length / 3;
        const vertices = new Float32Array(3 * n);
        for (let i = 0; i < n; i++) for (let x = 0; x < 3; x++) vertices[3 * i + x] = one.low[x] + one.step * steps[x * n + i];
        const {place, normal, count} = shaded(vertices, faces, 0.7), {gl} = this;
        const arrays = [["place", place, gl.FLOAT, false], ["normal", normal, gl.FLOAT, false]];
        this.surfaces.push({...buffered(gl, this.surface, arrays, count), pose: transposed(body.pose), part: one.part,
          colour: colours[body.id].map((c) => c / 255), id: body.id});
      }
  }

  // Set lines (pairs of points with a colour) or points of a group.
  setLines(name, lines) {
    const places = new Float32Array(lines.flatMap(([a, b]) => [...a, ...b]));
    const paint = new Uint8Array(lines.flatMap(([, , colour]) => [...colour, ...colour]));
    this.setGroup(name, places, paint, 2 * lines.length, this.gl.LINES);
  }

  setGroup(name, places, paint, count, mode) {
    const {gl} = this;
    const arrays = [["place", places, gl.FLOAT, false], ["paint", paint, gl.UNSIGNED_BYTE, true]];
    this.groups[name] = {...buffered(gl, this.point, arrays, count), mode};
  }

  draw(shown, size, ground) {
    const {gl, canvas} = this, ratio = window.devicePixelRatio || 1;
    canvas.width = Math.max(1, Math.round(canvas.clientWidth * ratio));
    canvas.height = Math.max(1, Math.round(canvas.clientHeight * ratio));
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(...ground, 1);
    gl.enable(gl.DEPTH_TEST);
    gl.depthMask(true);
    gl.disable(gl.BLEND);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const [camera, eye] = this.sight();
    const opaque = this.surfaces.filter((one) => one.part === "opaque" && shown.has(one.id === 1 ? "table" : "meshes"));
    const clear = this.surfaces.filter((one) => one.part !== "opaque" && shown.has("meshes"));
    this.drawSurfaces(opaque, camera, eye);
    gl.useProgram(this.point);
    gl.uniformMatrix4fv(gl.getUniformLocation(this.point, "camera"), false, camera);
    gl.uniform1f(gl.getUniformLocation(this.point, "size"), size * ratio);
    for (const [name, group] of Object.entries(this.groups)) {
      if (!shown.has(name) || !group.count) continue;
      gl.bindVertexArray(group.vao);
      gl.drawArrays(group.mode, 0, group.count);
    }
    gl.enable(gl.BLEND);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.depthMask(false);
    this.drawSurfaces(clear, camera, eye);
    gl.depthMask(true);
    return camera;
  }

  drawSurfaces(surfaces, camera, eye) {
    const {gl, surface: used} = this, place = (name) => gl.getUniformLocation(used, name);
    gl.useProgram(used);
    gl.uniformMatrix4fv(place("camera"), false, camera);
    gl.uniform3fv(place("eye"), eye);
    for (const one of surfaces) {
      const clear = one.part !== "opaque", tint = {wet_wall: 0.28, liquid_surface: 0.45, liquid_interface: 0.4}[one.part];
      gl.uniformMatrix4fv(place("world"), false, one.pose);
      gl.uniform4f(place("colour"), ...one.colour, clear ? tint || 0.12 : 1);
      gl.uniform1f(place("glass"), clear ? 1 : 0);
      gl.bindVertexArray(one.vao);
      gl.drawArrays(gl.TRIANGLES, 0, one.count);
    }
  }
}
