"use strict";
// Maps as colours, and their numbers at a pixel.

const NOTHING = [45, 45, 48];
const ABOVE = [178, 24, 43], BELOW = [33, 102, 172];
const rgbOf = (hex) => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));

// Return what gives the colour of a pixel's numbers, `at` being the first of them.
function colouring(map, data, ids, ramp) {
  const names = map.names.map(([, colour]) => rgbOf(colour)), span = map.high - map.low || 1;
  return {
    ids: (at) => ids[data[at]] || NOTHING,
    number: (at) => {
      if (data[at] === map.none) return NOTHING;
      const level = Math.min(1, Math.max(0, (data[at] * map.step - map.low) / span));
      return ramp[Math.round(255 * level)];
    },
    // Blue below 0, white at 0, red above, as `core.images.difference_colours`.
    signed: (at) => {
      if (data[at] === map.none) return NOTHING;
      const level = Math.min(1, Math.max(-1, data[at] * map.step / map.high));
      return (level > 0 ? ABOVE : BELOW).map((full) => 255 + Math.abs(level) * (full - 255));
    },
    // A half turn as all hues, as bright as the second number.
    angle: (at) => {
      const hue = data[at] * map.step / 30, bright = 255 * Math.pow(data[at + 1] / 255, 1 / 2.2);
      return [5, 3, 1].map((n) => {
        const k = (n + hue) % 6;
        return bright * (1 - Math.max(0, Math.min(k, 4 - k, 1)));
      });
    },
    vector: (at) => {
      const [x, y, z] = [data[at], data[at + 1], data[at + 2]];
      return x || y || z ? [127.5 + x, 127.5 - y, 127.5 - z] : NOTHING;
    },
    colour: (at) => (data[at] === map.none ? NOTHING : [data[at], data[at + 1], data[at + 2]]),
    class: (at) => names[data[at]] || NOTHING,
    bits: (at) => {
      const on = names.filter((_, bit) => data[at] >> bit & 1);
      return on.length ? [0, 1, 2].map((c) => on.reduce((sum, colour) => sum + colour[c], 0) / on.length) : NOTHING;
    },
    // Direction as hue, length as saturation.
    flow: (at) => {
      if (data[at] === map.none) return NOTHING;
      const x = data[at] * map.step, y = data[at + 1] * map.step, turn = Math.atan2(y, x);
      const full = Math.min(1, Math.hypot(x, y) / map.high);
      return [0, 1, 2].map((c) => 255 * (1 - full * (0.5 - 0.5 * Math.cos(turn - c * 2.0944))));
    },
  }[map.kind];
}

async function paint(canvas, map, ids, ramp) {
  const data = await values(map.data), [height, width] = map.data.shape, channels = map.data.shape[2] || 1;
  const colour = colouring(map, data, ids, ramp), image = new ImageData(width, height);
  for (let i = 0; i < width * height; i++) {
    const [r, g, b] = colour(i * channels);
    image.data.set([r, g, b, 255], 4 * i);
  }
  canvas.width = width;
  canvas.height = height;
  canvas.getContext("2d").putImageData(image, 0, 0);
}

const digits = (value, step) => value.toFixed(Math.min(4, Math.max(0, Math.ceil(-Math.log10(step) - 1e-9))));

// Return a map's numbers at a pixel as text.
function reading(map, data, at, names) {
  const first = data[at], several = (n) => Array.from(data.slice(at, at + n), (v) => digits(v * map.step, 0.01)).join(", ");
  if (map.kind === "ids") return first ? `${first} ${names[first] || ""}`.trim() : "nothing";
  if (map.kind === "class") return (map.names[first] || ["none"])[0];
  if (map.kind === "bits") return map.names.filter((_, bit) => first >> bit & 1).map(([name]) => name).join(", ") || "none";
  if (map.kind === "vector") return data[at] || data[at + 1] || data[at + 2] ? several(3) : "none";
  if (first === map.none) return "none";
  if (map.kind === "colour")
    return Array.from(data.slice(at, at + 3), (v) => digits((v - (map.none === 0 ? 1 : 0)) * map.step, 0.01)).join(", ");
  if (map.kind === "flow") return `${several(2)} ${map.unit}`;
  return `${digits(first * map.step, map.step)} ${map.unit}`.trim();
}

// Draw lines and points of a view's objects on a canvas; `scale` is pixels of the canvas a pixel of the picture.
function drawShapes(context, objects, lines, shown, colours, scale, only) {
  const at = ([u, v]) => [(u + 0.5) * scale, (v + 0.5) * scale];
  const stroke = (points, colour, width, closed) => {
    context.beginPath();
    points.forEach((point, i) => context[i ? "lineTo" : "moveTo"](...at(point)));
    if (closed) context.closePath();
    for (const [ink, wide] of [["rgba(0,0,0,.55)", width + 2], [colour, width]]) {
      context.strokeStyle = ink;
      context.lineWidth = wide;
      context.stroke();
    }
  };
  const box = ([l, t, r, b], colour, dash) => {
    context.setLineDash(dash);
    stroke([[l, t], [r, t], [r, b], [l, b]], colour, 1.5, true);
    context.setLineDash([]);
  };
  const disc = (point, colour, radius) => {
    context.beginPath();
    context.arc(...at(point), radius, 0, 2 * Math.PI);
    context.fillStyle = colour;
    context.fill();
    context.lineWidth = 1.2;
    context.strokeStyle = "#111";
    context.stroke();
  };
  for (const item of objects) {
    if (only && only !== item.id) continue;
    const colour = `rgb(${colours[item.id]})`;
    if (shown.has("silhouettes")) for (const line of item.silhouette) stroke(line, colour, 1.5, true);
    if (shown.has("boxes")) item.modal && box(item.modal, colour, []);
    if (shown.has("amodal boxes")) item.amodal && box(item.amodal, colour, [6, 4]);
    if (shown.has("3D boxes")) for (const edge of item.edges) stroke(edge, colour, 1.5);
    if (shown.has("axes")) item.axes.forEach((edge, i) => stroke(edge, ["#eb3c3c", "#46cd50", "#5082ff"][i], 2.5));
    if (shown.has("keypoints")) for (const [u, v, state] of item.keypoints) disc([u, v], KEYPOINTS[state], 4.5);
    if (shown.has("names") && item.centre && (item.modal || item.silhouette.length)) {
      context.font = "600 12px system-ui, sans-serif";
      context.textAlign = "center";
      context.lineWidth = 3;
      context.strokeStyle = "rgba(0,0,0,.75)";
      context.strokeText(`${item.id}`, ...at(item.centre));
      context.fillStyle = "#fff";
      context.fillText(`${item.id}`, ...at(item.centre));
    }
  }
  for (const [name, colour] of [["openings", "#fabe32"], ["fill lines", "#6ec8ff"]])
    if (shown.has(name)) for (const line of lines[name] || []) stroke(line, colour, 1.8, true);
}
const KEYPOINTS = {visible: "#50e15f", through_glass: "#46beff", occluded: "#f04b41", outside: "#fabe32"};
