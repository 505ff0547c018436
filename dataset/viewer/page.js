"use strict";
// What is shown is in the address behind #, so that a view of it can be kept, sent and tested.

const head = record("head");
const RAMP = Array.from({length: 256}, (_, i) => head.ramp.slice(3 * i, 3 * i + 3));
const TABS = ["picture", "maps", "space", "objects"];
const SHAPES = ["silhouettes", "boxes", "amodal boxes", "3D boxes", "axes", "keypoints", "names", "openings", "fill lines"];
const SOLIDS = ["table", "meshes", "boxes", "cameras", "cloud", "keypoints", "names"];
const START = {scene: "0", view: "0", tab: "picture", eye: "left", map: "", show: "names", opacity: "1", solid: "",
  camera: "", pixel: "", size: "2", object: ""};
const state = {...START};
let scene, view, space, colours = {}, names = {};

const current = () => head.scenes[state.scene] || head.scenes[0];
const listed = (key) => new Set(state[key] ? state[key].split(",") : []);

function readAddress() {
  Object.assign(state, START, Object.fromEntries(new URLSearchParams(location.hash.slice(1))));
  if (!head.scenes[state.scene]) state.scene = "0";
  if (!(Number(state.view) < current().views.length)) state.view = "0";
  if (!TABS.includes(state.tab)) state.tab = "picture";
}

function set(changes) {
  Object.assign(state, changes);
  const kept = Object.entries(state).filter(([key, value]) => value !== START[key]);
  history.replaceState(null, "", "#" + new URLSearchParams(kept));
  show();
}

const toggle = (key, name) => {
  const found = listed(key);
  found.delete(name) || found.add(name);
  set({[key]: [...found].join(",")});
};

let shownScene = "", shownView = "";
async function show() {
  const place = `${state.scene}-${state.view}`;
  if (shownScene !== state.scene) {
    scene = record(`scene-${state.scene}`);
    colours = Object.fromEntries(Object.entries(scene.colours).map(([id, colour]) => [id, colour]));
    names = scene.names;
    shownScene = state.scene;
    if (space) await fillSpace();
  }
  if (shownView !== place) {
    view = record(`view-${place}`);
    shownView = place;
    if (!view.pictures[state.eye]) state.eye = "left";
    showSides();
    if (state.tab === "maps") await showMaps();
  }
  for (const tab of TABS) {
    byId(tab).hidden = tab !== state.tab;
    byId(`to-${tab}`).setAttribute("aria-selected", tab === state.tab);
  }
  byId("scene").value = state.scene;
  byId("view").value = state.view;
  await {picture: showPicture, maps: showMaps, space: showSpace, objects: showObjects}[state.tab]();
  document.body.dataset.ready = `${place} ${state.tab}`;
}

// ---- picture

// Columns and rows of a picture and of its maps; infrared cameras have sizes of their own.
const sizeOf = (eye) => (view.sizes || {})[eye] || [view.width, view.height];
const mapsOf = (eye) => view.maps.filter((map) => map.name.startsWith(`${eye}/`));
const chosen = () => mapsOf(state.eye).find((map) => map.name === `${state.eye}/${state.map}`);

function choices(kind, key, list, onclick, isOn) {
  return list.map(([value, text, colour]) =>
    element("label", {class: "choice"}, element("input", {type: kind, name: key, checked: isOn(value), onchange: () => onclick(value)}),
      ...(colour ? [element("i", {style: `background:${colour}`})] : []), text));
}

// The lists beside the picture, for the view and the eye.
function showSides() {
  const eyes = Object.keys(view.pictures).map((eye) => [eye, eye]);
  byId("eyes").replaceChildren(...choices("radio", "eye", eyes, (eye) => set({eye}), (eye) => eye === state.eye));
  const groups = new Map([["", [["", "picture alone"]]]]);
  for (const map of mapsOf(state.eye)) {
    if (!groups.has(map.group)) groups.set(map.group, []);
    groups.get(map.group).push([map.name.slice(state.eye.length + 1), map.title]);
  }
  const parts = [];
  for (const [group, list] of groups) {
    const found = choices("radio", "map", list, (map) => set({map}), (map) => map === state.map);
    const open = list.length < 8 || list.some(([map]) => map === state.map);
    parts.push(...(group ? [element("details", {open}, element("summary", {}, group), ...found)] : found));
  }
  byId("map-list").replaceChildren(...parts);
  const shapes = SHAPES.filter((name) => !view.lines[name] || view.lines[name].length);
  byId("shape-list").replaceChildren(
    ...choices("checkbox", "show", shapes.map((name) => [name, name]), (name) => toggle("show", name), (name) => listed("show").has(name)));
  const objects = [["", "all"], ...(view.shapes.left || []).map((one) => [`${one.id}`, `${one.id} ${names[one.id]}`, `rgb(${colours[one.id]})`])];
  byId("object-list").replaceChildren(
    ...choices("radio", "object", objects, (object) => set({object}), (id) => id === state.object));
  const absent = [...Object.entries(view.absent).map(([kind, purpose]) => `${purpose} (--write ${kind})`), ...(view.lacks || [])];
  byId("absent").replaceChildren(...absent.map((text) => element("p", {class: "soft"}, `not in this data set: ${text}`)));
}

let sidesOf = "";
async function showPicture() {
  const key = `${shownView} ${state.eye}`;
  if (sidesOf !== key) showSides();
  sidesOf = key;
  for (const [name, value] of [["eye", state.eye], ["map", state.map], ["object", state.object]])
    document.querySelectorAll(`#picture input[name=${name}]`).forEach((input, i) => {
      const list = name === "eye" ? Object.keys(view.pictures) : name === "map" ? ["", ...mapsOf(state.eye).map((m) => m.name.slice(state.eye.length + 1))]
        : ["", ...view.shapes.left.map((one) => `${one.id}`)];
      input.checked = list[i] === value;
    });
  document.querySelectorAll("#shape-list input").forEach((input) =>
    (input.checked = listed("show").has(input.parentElement.textContent)));
  const stage = byId("stage"), [width, height] = sizeOf(state.eye);
  stage.style.aspectRatio = `${width} / ${height}`;
  stage.style.setProperty("--ratio", width / height);
  byId("photo").src = view.pictures[state.eye];
  const map = chosen(), canvas = byId("map");
  canvas.hidden = !map;
  canvas.style.opacity = state.opacity;
  byId("opacity").value = state.opacity;
  if (map) await paint(canvas, map, colours, RAMP);
  const states = listed("show").has("keypoints") ? Object.entries(KEYPOINTS) : [];
  byId("legend").replaceChildren(...(map ? legend(map) : []), ...states.map(([name, colour]) =>
    element("span", {}, element("i", {class: "dot", style: `background:${colour}`}), name.replace("_", " "))));
  drawOverlay();
  await read();
}

function drawOverlay() {
  const canvas = byId("shapes"), ratio = window.devicePixelRatio || 1, wide = byId("stage").clientWidth;
  canvas.width = wide * ratio;
  canvas.height = byId("stage").clientHeight * ratio;
  const context = canvas.getContext("2d");
  context.scale(ratio, ratio);
  const objects = view.shapes[state.eye] || [], lines = state.eye === "left" ? view.lines : {};
  drawShapes(context, objects, lines, listed("show"), colours, wide / view.size[0], Number(state.object));
}

function legend(map) {
  if (map.names.length)
    return map.names.filter(([name]) => name !== "none")
      .map(([name, colour]) => element("span", {}, element("i", {style: `background:${colour}`}), name));
  if (map.kind === "number") {
    const stops = RAMP.filter((_, i) => i % 32 === 0 || i === 255).map((colour) => `rgb(${colour})`);
    const text = (value) => `${Number(value.toPrecision(4))} ${map.unit}`;
    return [element("span", {}, text(map.low), element("i", {class: "ramp", style: `background:linear-gradient(90deg,${stops})`}), text(map.high))];
  }
  if (map.kind === "signed") {
    const stops = [BELOW, [255, 255, 255], ABOVE].map((colour) => `rgb(${colour})`), text = (value) => `${value} ${map.unit}`.trim();
    return [element("span", {}, text(map.low), element("i", {class: "ramp", style: `background:linear-gradient(90deg,${stops})`}), text(map.high))];
  }
  return {vector: ["red: right, green: up, blue: towards the camera"],
    angle: ["hue: angle from the rows of the picture (red 0, cyan 90 deg), as bright as the degree"],
    flow: [`hue: direction (red right), full colour from ${map.high.toFixed(1)} px on`]}[map.kind] || [];
}

// The numbers of all maps at a pixel: `pixel` is column,row of the maps.
async function read() {
  const [column, row] = state.pixel.split(",").map(Number), list = byId("numbers"), [width, height] = sizeOf(state.eye);
  if (state.pixel === "" || !(column >= 0 && column < width && row >= 0 && row < height)) {
    list.replaceChildren(element("p", {class: "soft"}, "Point at the picture to read its labels."));
    return;
  }
  const rows = [element("tr", {}, element("td", {}, "pixel"), element("td", {}, state.pixel.replace(",", ", ")))];
  const wanted = mapsOf(state.eye), found = await Promise.all(wanted.map((map) => values(map.data)));
  wanted.forEach((map, i) => {
    const at = (row * width + column) * (map.data.shape[2] || 1);
    rows.push(element("tr", {"data-map": map.name, class: map === chosen() ? "on" : false},
      element("td", {}, map.title), element("td", {}, reading(map, found[i], at, names))));
  });
  list.replaceChildren(element("table", {}, ...rows));
}

// ---- all maps

let mapsShown = "";
async function showMaps() {
  if (mapsShown === shownView) return;
  mapsShown = shownView;
  const grid = byId("maps");
  const cell = (title, shown, onclick) => element("figure", {onclick}, shown, element("figcaption", {}, title));
  const cells = Object.entries(view.pictures).map(([eye, src]) =>
    cell(`${eye} picture`, element("img", {src, alt: ""}), () => set({tab: "picture", eye, map: ""})));
  const canvases = view.maps.map((map) => {
    const [eye] = map.name.split("/"), canvas = element("canvas");
    cells.push(cell(`${eye === "right" ? "right: " : ""}${map.title}`, canvas,
      () => set({tab: "picture", eye, map: map.name.slice(eye.length + 1), opacity: "1"})));
    return [canvas, map];
  });
  grid.replaceChildren(...cells);
  for (const [canvas, map] of canvases) await paint(canvas, map, colours, RAMP);
}

// ---- space

const solids = () => (state.solid ? listed("solid") : new Set(["table", "meshes", "cameras", "names", "boxes"]));
const groundColour = () => getComputedStyle(document.body).getPropertyValue("--space").split(",").map((c) => Number(c) / 255);

function edgesOf(body) {
  const m = transposed(body.pose), corner = (i) => apply(m, body.size.map((s, axis) => (i >> axis & 1 ? s : -s) / 2)).slice(0, 3);
  return [[0, 1], [2, 3], [4, 5], [6, 7], [0, 2], [1, 3], [4, 6], [5, 7], [0, 4], [1, 5], [2, 6], [3, 7]]
    .map(([a, b]) => [corner(a), corner(b), colours[body.id]]);
}

function frustum({K, pose, width, height}, depth, colour) {
  const m = transposed(pose), corner = (u, v) => apply(m, [(u - K[0][2]) / K[0][0] * depth, (v - K[1][2]) / K[1][1] * depth, depth]).slice(0, 3);
  const eye = [pose[3], pose[7], pose[11]], c = [[0, 0], [width - 1, 0], [width - 1, height - 1], [0, height - 1]].map(([u, v]) => corner(u, v));
  return [0, 1, 2, 3].flatMap((i) => [[eye, c[i], colour], [c[i], c[(i + 1) % 4], colour]]);
}

async function fillSpace() {
  await space.setBodies(scene.bodies, colours);
  space.setLines("boxes", scene.bodies.filter((body) => body.size).flatMap(edgesOf));
  if (scene.target) space.target = scene.target;
  const drawn = (camera, colour) => (camera ? frustum(camera, 0.1, colour) : []);
  const cameras = scene.cameras.flatMap((pair, i) => [
    ...drawn(pair.left, i === Number(state.view) ? [250, 190, 50] : [150, 150, 160]), ...drawn(pair.right, [110, 130, 170]),
    // Parts of a depth camera stand millimetres apart: small, so that they can be told apart.
    ...(pair.rig || []).flatMap((part) => frustum(part, 0.03, part.name === "projector" ? [235, 80, 70] : [185, 105, 225]))]);
  space.setLines("cameras", cameras);
  const points = scene.bodies.filter((body) => body.keypoints).flatMap((body) => {
    const m = transposed(body.pose);
    return body.keypoints.map((point) => [...apply(m, point).slice(0, 3)]);
  });
  space.setGroup("keypoints", new Float32Array(points.flat()), new Uint8Array(points.flatMap(() => [250, 220, 60])), points.length, space.gl.POINTS);
}

let cloudOf = "";
async function fillCloud() {
  if (cloudOf === shownView) return;
  cloudOf = shownView;
  if (!view.cloud) return space.setGroup("cloud", new Float32Array(), new Uint8Array(), 0, space.gl.POINTS);
  const places = await values(view.cloud.points), paint = await values(view.cloud.colours), n = places.length / 3;
  const rows = (data, Kind) => Kind.from({length: 3 * n}, (_, i) => data[(i % 3) * n + Math.floor(i / 3)]);
  space.setGroup("cloud", rows(places, Float32Array), rows(paint, Uint8Array), n, space.gl.POINTS);
}

let frame = 0;
async function showSpace() {
  if (!space) {
    space = new Space(byId("world"), () => {
      cancelAnimationFrame(frame);
      frame = requestAnimationFrame(drawSpace);
    });
    byId("solids").replaceChildren(...choices("checkbox", "solid", SOLIDS.map((name) => [name, name]), (name) => {
      const found = solids();
      found.delete(name) || found.add(name);
      set({solid: [...found].join(",") || "none"});
    }, (name) => solids().has(name)));
    if (!space.gl) return byId("world").replaceWith(element("p", {}, "This browser has no WebGL 2."));
    await fillSpace();
  }
  if (!space.gl) return;
  if (solids().has("cloud")) await fillCloud();
  const cameras = scene.cameras.map((_, i) => [`${i}`, `camera ${current().views[i] ?? i}`]);
  byId("camera-list").replaceChildren(element("option", {value: ""}, "free"), ...cameras.map(([value, text]) =>
    element("option", {value}, text)));
  byId("camera-list").value = state.camera;
  space.camera = state.camera === "" ? null : scene.cameras[Number(state.camera)]?.left || null;
  drawSpace();
}

function drawSpace() {
  if (!space.camera && state.camera !== "") {
    state.camera = "";
    byId("camera-list").value = "";
  }
  const camera = space.draw(solids(), Number(state.size), groundColour());
  const labels = [], box = byId("world");
  if (solids().has("names")) {
    const places = scene.bodies.filter((body) => body.size).map((body) => [`${body.id}`, [body.pose[3], body.pose[7], body.pose[11]]]);
    scene.cameras.forEach((pair, i) =>
      pair.left && places.push([`camera ${current().views[i]}`, [pair.left.pose[3], pair.left.pose[7], pair.left.pose[11]]]));
    for (const [text, place] of places) {
      const [x, y, , w] = apply(camera, place);
      if (w < 0.02 || Math.abs(x) > w || Math.abs(y) > w) continue;
      const left = (x / w + 1) / 2 * box.clientWidth, top = (1 - y / w) / 2 * box.clientHeight;
      labels.push(element("span", {style: `left:${left.toFixed(1)}px;top:${top.toFixed(1)}px`}, text));
    }
  }
  byId("labels").replaceChildren(...labels);
}

// ---- objects

function showObjects() {
  const numbers = view.numbers || {titles: [], rows: {}};
  const seen = Object.fromEntries((view.shapes.left || []).map((one) => [one.id, one.fractions]));
  const percent = (one, key) => (one ? `${(100 * one[key]).toFixed(1)} %` : "-");
  const rows = scene.objects.map((one) => element("tr", {},
    element("td", {}, element("i", {style: `background:rgb(${colours[one.id]})`}), `${one.id}`),
    ...one.cells.map((text) => element("td", {}, text)),
    ...["visible", "seen_through", "occluded"].map((key) => element("td", {}, percent(seen[one.id], key))),
    ...(numbers.rows[one.id] || []).map((text) => element("td", {}, text))));
  const titles = ["id", ...head.columns, "visible", "through glass", "occluded", ...numbers.titles];
  byId("object-table").replaceChildren(element("tr", {}, ...titles.map((title) => element("th", {}, title))), ...rows);
}

// ---- the page

function begin() {
  for (const tab of TABS) byId(`to-${tab}`).addEventListener("click", () => set({tab}));
  const options = (list) => list.map(([value, text]) => element("option", {value}, text));
  const fill = () => byId("view").replaceChildren(...options(current().views.map((view, i) => [i, `view ${view}`])));
  byId("scene").replaceChildren(...options(head.scenes.map((one, i) => [i, `scene ${one.id}`])));
  fill();
  byId("scene").addEventListener("change", (event) => {
    set({scene: event.target.value, view: "0", camera: "", pixel: "", object: ""});
    fill();
  });
  byId("view").addEventListener("change", (event) => set({view: event.target.value, pixel: ""}));
  byId("opacity").addEventListener("input", (event) => set({opacity: event.target.value}));
  byId("size").addEventListener("input", (event) => set({size: event.target.value}));
  byId("camera-list").addEventListener("change", (event) => set({camera: event.target.value}));
  const stage = byId("stage");
  stage.addEventListener("pointermove", (event) => {
    const box = stage.getBoundingClientRect(), [width, height] = sizeOf(state.eye);
    state.pixel = [(event.clientX - box.left) / box.width * width, (event.clientY - box.top) / box.height * height].map(Math.floor).join(",");
    read();
  });
  document.addEventListener("keydown", (event) => {
    const step = {ArrowLeft: -1, ArrowRight: 1}[event.key];
    if (!step || event.target.matches("input,select")) return;
    set({view: `${(Number(state.view) + step + current().views.length) % current().views.length}`});
  });
  addEventListener("resize", () => show());
  addEventListener("hashchange", () => {
    readAddress();
    fill();
    show();
  });
  show();
}

addEventListener("unhandledrejection", (event) => (document.body.dataset.failed = `${event.reason}`));
addEventListener("error", (event) => (document.body.dataset.failed = event.message));
readAddress();
if (head.scenes.length) begin();
