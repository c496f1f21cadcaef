// Meshes of the user's own: what is read of them, and what is said of those that cannot be.
import type { BufferGeometry } from "three";
import { expect, test } from "vitest";
import { readMesh } from "../src/index.js";

const read = (text: string): BufferGeometry => readMesh(new TextEncoder().encode(text));
const values = (geometry: BufferGeometry, name: string): number[] => Array.from(geometry.getAttribute(name).array, (v) => Math.round(1e4 * v) / 1e4 + 0);

const SQUARE = "# a square\nv 0 0 0\nv 1 0 0 1.0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0 0\nvt 1 1\nvt 0 1\nvn 0 0 2\no name\nf 1/1/1 2/2/1 3/3/1 \\\n -1/-1/-1 # the only face\n";

test("a square is two triangles over four vertices, with or without normals", () => {
  for (const text of [SQUARE, SQUARE.replace("vn 0 0 2\n", "").replaceAll("/1/1 ", "/1 ").replace("2/2/1 3/3/1", "2/2 3/3").replace("-1/-1/-1", "4/4")]) {
    const square = read(text);
    expect(values(square, "position")).toEqual([0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0]);
    expect(values(square, "normal")).toEqual([0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1]);
    expect(values(square, "uv")).toEqual([0, 0, 1, 0, 1, 1, 0, 1]);
    expect([...(square.getIndex()?.array ?? [])]).toEqual([0, 1, 2, 0, 2, 3]);
    const tangents = values(square, "tangent");
    for (let i = 0; i < 16; i += 4) expect([Math.sign(tangents[i] ?? 0), ...tangents.slice(i + 1, i + 4)]).toEqual([1, 0, 0, 1]);
  }
});

test("a mesh without an extent is refused", () => {
  expect(() => read(SQUARE.replaceAll(/^v (.) (.) 0/gm, "v $1e-30 $2e-30 0"))).toThrow("export the mesh in other units");
});

test("mirrored halves that share vertices keep their tangents", () => {
  const places = [[-1, 0], [0, 0], [1, 0], [-1, 1], [0, 1], [1, 1]] as const;
  const halves = read([...places.flatMap(([x, y]) => [`v ${x} ${y} 0`, `vt ${Math.abs(x)} ${y}`]), "f 1/1 2/2 5/5 4/4", "f 2/2 3/3 6/6 5/5"].join("\n"));
  const tangents = values(halves, "tangent"), positions = values(halves, "position");
  // The two vertices of the seam are there twice.
  expect(positions.length).toBe(3 * 8);
  for (let i = 0; i < 8; i++) {
    const [x = 0, y, z, sign = 0] = tangents.slice(4 * i, 4 * i + 4);
    expect([y, z]).toEqual([0, 0]);
    expect(Math.sign(x)).toBe(sign);
    if (positions[3 * i] !== 0) expect(sign).toBe(Math.sign(positions[3 * i] ?? 0));
  }
});

test("a face that is not convex is cut by its ears", () => {
  const arrow = [[0, 0], [4, 0], [1, 1], [0, 4]] as const, text = arrow.flatMap(([x, y]) => [`v ${x} ${y} 0`, `vt ${x} ${y}`]).join("\n");
  for (const turn of [0, 1, 2, 3]) {
    const face = [0, 1, 2, 3].map((i) => `${((i + turn) % 4) + 1}/${((i + turn) % 4) + 1}`).join(" ");
    const geometry = read(`${text}\nf ${face}\n`), index = [...(geometry.getIndex()?.array ?? [])], at = values(geometry, "position");
    const area = [0, 3].map((t) => {
      const [a = 0, b = 0, c = 0] = index.slice(t, t + 3), p = (i: number, k: number): number => at[3 * i + k] ?? 0;
      return (p(b, 0) - p(a, 0)) * (p(c, 1) - p(a, 1)) - (p(c, 0) - p(a, 0)) * (p(b, 1) - p(a, 1));
    });
    expect(area.every((twice) => twice > 0)).toBe(true);
    expect((area[0] ?? 0) + (area[1] ?? 0)).toBeCloseTo(8);
  }
});

/** A triangle as binary glTF, of which parts of the JSON may be other. */
function glb(change: (json: Record<string, unknown>) => void = () => undefined): Uint8Array {
  const floats = [0, 0, 0, 1, 0, 0, 0, 1, 0, /* texture coordinates */ 0, 1, 1, 1, 0, 0];
  const binary = new Uint8Array(64);
  binary.set(new Uint8Array(Float32Array.from(floats).buffer));
  binary.set([0, 1, 2], 60);
  const json = {
    asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ children: [1], translation: [0, 0, 5] }, { mesh: 0, scale: [2, 2, 2] }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0, TEXCOORD_0: 1 }, indices: 2 }] }], buffers: [{ byteLength: 64 }],
    bufferViews: [{ buffer: 0, byteLength: 36 }, { buffer: 0, byteOffset: 36, byteLength: 24 }, { buffer: 0, byteOffset: 60, byteLength: 3 }],
    accessors: [{ bufferView: 0, componentType: 5126, count: 3, type: "VEC3" }, { bufferView: 1, componentType: 5126, count: 3, type: "VEC2" }, { bufferView: 2, componentType: 5121, count: 3, type: "SCALAR" }],
  };
  change(json);
  const text = new TextEncoder().encode(JSON.stringify(json).padEnd(1200)), chunk = (kind: number, data: Uint8Array): number[] => [...new Uint8Array(Uint32Array.from([data.length, kind]).buffer), ...data];
  const body = [...chunk(0x4e4f534a, text), ...chunk(0x004e4942, binary)];
  return Uint8Array.from([...new Uint8Array(Uint32Array.from([0x46546c67, 2, 12 + body.length]).buffer), ...body]);
}

test("the triangles of binary glTF are placed by its nodes, and its texture coordinates run up", () => {
  const triangle = readMesh(glb());
  expect(values(triangle, "position")).toEqual([0, 0, 5, 2, 0, 5, 0, 2, 5]);
  expect(values(triangle, "uv")).toEqual([0, 0, 1, 0, 0, 1]);
  expect(values(triangle, "normal")).toEqual([0, 0, 1, 0, 0, 1, 0, 0, 1]);
});

/** Changes an accessor. */
function accessor(index: number, to: object): (json: Record<string, unknown>) => void {
  return (json) => void Object.assign((json["accessors"] as object[])[index] ?? {}, to);
}

test("what is no mesh, or a damaged one, is refused in a sentence", () => {
  for (const [from, to, sentence] of [
    ["v 1 0 0 1.0", "v 1 x 0", "line 3: 'v' needs 3 numbers"], ["3/3/1", "9/3/1", "line 12: a face refers to vertex 9, but there are 4 so far"],
    ["3/3/1", "3//1", "unwrap the mesh"], ["f 1", "g 1", "no triangles"], ["# a square", "ply", "PLY is not read"], ["# a square", '{"asset":', "text glTF"],
  ] as const)
    expect(() => read(SQUARE.replace(from, to)), to).toThrow(sentence);
  expect(() => read("")).toThrow("neither binary glTF nor OBJ");
  for (const [change, sentence] of [
    [(json) => (json["nodes"] = [{ children: [0] }]), "below one another"], [(json) => (json["scenes"] = []), "no scene"],
    [(json) => (json["extensionsRequired"] = ["KHR_draco_mesh_compression"]), "KHR_draco_mesh_compression"],
    [accessor(0, { count: 2 }), "differ in number"], [accessor(2, { count: 9 }), "beyond its bytes"], [accessor(2, { bufferView: 7 }), "accessor 2"],
  ] as [change: (json: Record<string, unknown>) => void, sentence: string][])
    expect(() => readMesh(glb(change)), sentence).toThrow(sentence);
  const letters = (text: string): Uint8Array => new TextEncoder().encode(text);
  for (const [file, sentence] of [
    [letters("some words"), "neither binary glTF nor OBJ"], [Uint8Array.of(0x89, 0x50, 0x4e, 0x47, 0, 0, 0), "the file is no mesh"],
    [letters("glTF1234"), "ends after 8 bytes"], [letters("glTF\x01\0\0\0\x14\0\0\0\0\0\0\0\0\0\0\0"), "glTF 1 is not read"],
  ] as const)
    expect(() => readMesh(file), sentence).toThrow(sentence);
  const whole = glb();
  for (let length = 4; length < whole.length; length += 7) expect(() => readMesh(whole.subarray(0, length)), `${length} bytes`).toThrow();
});
