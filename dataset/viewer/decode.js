"use strict";
// Data of the page: JSON records in elements of their own, so that only what is shown is parsed.

const byId = (id) => document.getElementById(id);
const record = (id) => JSON.parse(byId(id).textContent);
const TYPES = {u1: Uint8Array, i1: Int8Array, u2: Uint16Array, i2: Int16Array, u4: Uint32Array, f4: Float32Array};

// The inverse of `packed` in packing.py: base 64, inflate, bytes together, sums along rows.
async function unpack(one) {
  const text = atob(one.data), raw = new Uint8Array(text.length);
  for (let i = 0; i < raw.length; i++) raw[i] = text.charCodeAt(i);
  const stream = new Blob([raw]).stream().pipeThrough(new DecompressionStream("deflate"));
  const planes = new Uint8Array(await new Response(stream).arrayBuffer());
  const size = TYPES[one.type].BYTES_PER_ELEMENT, count = planes.length / size, bytes = new Uint8Array(planes.length);
  for (let plane = 0; plane < size; plane++)
    for (let i = 0; i < count; i++) bytes[i * size + plane] = planes[plane * count + i];
  const words = new {1: Uint8Array, 2: Uint16Array, 4: Uint32Array}[size](bytes.buffer);
  const stride = one.shape.length === 3 ? one.shape[2] : 1, row = one.shape[0] ? count / one.shape[0] : 0;
  for (let start = 0; start < count; start += row)
    for (let i = start + stride; i < start + row; i++) words[i] += words[i - stride];
  return new TYPES[one.type](bytes.buffer);
}

// What has been unpacked of the record that is shown.
const unpacked = new WeakMap();
function values(one) {
  if (!unpacked.has(one)) unpacked.set(one, unpack(one));
  return unpacked.get(one);
}

function element(tag, attributes = {}, ...inside) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes))
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else if (value !== false && value !== undefined) made.setAttribute(name, value === true ? "" : value);
  made.append(...inside);
  return made;
}
