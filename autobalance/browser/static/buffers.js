// A buffer of the server: four bytes that tell the length of a head in JSON, the head, then arrays.
const KINDS = { f4: Float32Array, u4: Uint32Array, u2: Uint16Array, u1: Uint8Array };

export function unpacked(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  const arrays = {};
  for (const [name, [place, count, kind]] of Object.entries(head.arrays)) arrays[name] = new KINDS[kind](buffer, 4 + length + place, count);
  return { head, arrays };
}
