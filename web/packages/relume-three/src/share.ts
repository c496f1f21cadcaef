import { FieldBoundaries } from "./boundaries.js";
import { EnvironmentLamps } from "./environment.js";
import { type FieldBlocks, type FieldCodes, type FieldData, FieldError, type FieldMap, type FieldNoise, fieldOf, planeCount } from "./field.js";
import { fromHalf, halvesOfPlane } from "./half.js";
import type { PlaneGroup, ShareHeader, ShareMap } from "./header.js";
import { parseHeader } from "./parseHeader.js";
import { MeasuredBasis } from "./measured.js";
import { decodePng, inflated } from "./png.js";
import { BasisTable } from "./table.js";
import { TiledShare } from "./pyramid.js";

/** Gives the bytes of a file of a shared texture by its name. */
export type FileSource = (name: string) => Promise<Uint8Array>;

/** A server that gives no answer, or none to the end: it may do so later. */
export class UnansweredError extends FieldError {
  override name = "UnansweredError";
}

/** The files of a folder on a web server. */
export function folderSource(url: string): FileSource {
  const base = url.endsWith("/") ? url : `${url}/`;
  return async (name) => {
    const silent = (): never => {
      throw new UnansweredError(`${name} cannot be loaded: the server does not answer`);
    };
    const response = await fetch(base + name.split("/").map(encodeURIComponent).join("/")).catch(silent);
    if (response.status >= 500) throw new UnansweredError(`${name} cannot be loaded: ${await sentenceOf(response)}`);
    if (!response.ok) throw new FieldError(`${name} cannot be loaded: ${await sentenceOf(response)}`);
    return new Uint8Array(await response.arrayBuffer().catch(silent));
  };
}

/** What the server says is wrong: the `error` of its JSON, or its status. */
export async function sentenceOf(response: Response): Promise<string> {
  const said: unknown = response.headers.get("Content-Type")?.startsWith("application/json") ? await response.json().catch(() => null) : null;
  const error = typeof said === "object" && said !== null && "error" in said ? said.error : null;
  return typeof error === "string" ? error : `the server answers ${response.status}`;
}

/** Files in memory, in base64. */
export function memorySource(files: Record<string, string>): FileSource {
  return async (name) => {
    const text = Object.hasOwn(files, name) ? files[name] : undefined;
    if (text === undefined) throw new FieldError(`${name} is missing`);
    return Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  };
}

/** Loads a shared texture, or the finest level of a large one; `progress` gets the share of its files that has arrived. */
export async function loadShare(source: FileSource, progress: (share: number) => void = () => undefined): Promise<FieldData> {
  const opened = await openShare(source, progress);
  return opened instanceof TiledShare ? opened.wholeLevel(opened.whole, progress) : opened;
}

/** Loads a shared texture, but of a large one only what all its tiles have in common. */
export async function openShare(source: FileSource, progress: (share: number) => void = () => undefined): Promise<FieldData | TiledShare> {
  const header = parseHeader(new TextDecoder().decode(await source("share.json")));
  if (header.pyramid) {
    const [environment, table] = await Promise.all([loadEnvironment(header, source), loadTable(header, source)]);
    return new TiledShare(header, header.pyramid, { environment, table }, source);
  }
  const total = header.planes.length + header.maps.length + 4;
  let done = 0;
  const counted = async <T>(work: Promise<T>): Promise<T> => {
    const result = await work;
    progress(++done / total);
    return result;
  };
  const texels = header.size[0] * header.size[1];
  const [environment, boundaries, table, noise, maps, groups] = await Promise.all([
    counted(loadEnvironment(header, source)),
    counted(loadBoundaries(header, texels, source)),
    counted(loadTable(header, source)),
    counted(loadNoise(header, source)),
    Promise.all(header.maps.map((map) => counted(loadMap(map, texels, source)))),
    Promise.all(header.planes.map((group) => counted(loadGroup(group, texels, source)))),
  ]);
  const planes = groups.flatMap((group) => group.planes);
  const map = (role: string): FieldMap | null => maps[header.maps.findIndex((map) => map.role === role)] ?? null;
  return fieldOf({
    title: header.title,
    width: header.size[0],
    height: header.size[1],
    space: header.space,
    layout: header.layout,
    channels: header.channels,
    basis: header.basis.name,
    functions: header.basis.functions,
    dependsOnView: header.basis.depends_on_view,
    lowestLight: header.basis.lowest_light ?? 0,
    table,
    planes,
    codes: codesOf(groups),
    normals: map("normals"),
    heights: map("height"),
    albedo: map("albedo"),
    mmPerTexel: header.mm_per_texel ?? null,
    cells: header.cells ?? null,
    noise,
    blocks: header.blocks ? loadedBlocks(header, header.blocks.side, source) : null,
    environment,
    boundaries,
  });
}

async function loadNoise({ noise, basis, channels }: ShareHeader, source: FileSource): Promise<FieldNoise | null> {
  if (!noise) return null;
  const numbers = async (file: string, count: number): Promise<Float32Array> => {
    const bytes = await inflated([await source(file)], "gzip", 4 * count);
    if (bytes.length !== 4 * count) throw new FieldError(`${file} has ${bytes.length} bytes: expected ${4 * count}`);
    return new Float32Array(bytes.buffer, bytes.byteOffset, count);
  };
  const [tables, functions] = await Promise.all([
    numbers(noise.tables, noise.planes * noise.entries),
    numbers(noise.functions, (noise.planes + 1) * channels * basis.functions),
  ]);
  return { ...noise, tables, functions };
}

function loadedBlocks({ layout, basis }: ShareHeader, side: number, source: FileSource): FieldBlocks {
  const count = planeCount(layout, basis.functions);
  return { side, load: (column, row) => loadHalves(`block_${column}_${row}.f16.gz`, count, side * side, source) };
}

async function loadEnvironment({ environment }: ShareHeader, source: FileSource): Promise<EnvironmentLamps | null> {
  return environment ? new EnvironmentLamps(environment, await inflated([await source(environment.file)], "gzip", EnvironmentLamps.bytes(environment))) : null;
}

async function loadBoundaries({ shapes, basis, channels }: ShareHeader, texels: number, source: FileSource): Promise<FieldBoundaries | null> {
  if (!shapes) return null;
  const bytes = FieldBoundaries.bytes(basis.functions, channels, texels);
  return new FieldBoundaries(shapes, basis.functions, channels, texels, await inflated([await source(shapes.file)], "gzip", bytes));
}

async function loadTable({ basis }: ShareHeader, source: FileSource): Promise<FieldData["table"]> {
  const { functions, channels, table, measured } = basis;
  const numbers = async (file: string, count: number): Promise<Uint16Array> => halves(await inflated([await source(file)], "gzip", 2 * count));
  if (measured) {
    const [values, corners] = await Promise.all([
      numbers(measured.file, MeasuredBasis.numbers(functions, channels, measured.lights.length, measured.views.length)),
      numbers(measured.corners, MeasuredBasis.corners(measured.map_nodes)),
    ]);
    return new MeasuredBasis(measured.lights, measured.views, functions, channels, values, measured.map_nodes, corners);
  }
  if (!table) return null;
  const count = BasisTable.numbers(functions, channels, table.light_nodes * table.view_nodes);
  return new BasisTable(table.light_nodes, table.view_nodes, functions, channels, await numbers(table.file, count));
}

/** Planes of a file of half floats. */
async function loadHalves(file: string, count: number, texels: number, source: FileSource): Promise<Uint16Array[]> {
  const values = halves(await inflated([await source(file)], "gzip", 2 * count * texels));
  if (values.length !== count * texels) throw new FieldError(`${file} has ${values.length} numbers: expected ${count * texels}`);
  return Array.from({ length: count }, (_, k) => values.subarray(k * texels, (k + 1) * texels));
}

/** Planes as half floats, and as codes where they are stored so. */
interface LoadedGroup {
  planes: Uint16Array[];
  codes: FieldCodes | null;
}

async function loadGroup(group: PlaneGroup, texels: number, source: FileSource): Promise<LoadedGroup> {
  if (group.storage === "half") return { planes: await loadHalves(group.file, group.count, texels, source), codes: null };
  const range = Array.from({ length: group.count }, (_, k) => k), scale = range.map((k) => group.scale?.[k] ?? 1 / 255), offset = range.map((k) => group.offset?.[k] ?? 0);
  const { codes, channels } = await decodePng(await source(group.file), texels);
  if (codes.length !== channels * texels || channels < group.count) throw new FieldError(`${group.file} has another size than the texture`);
  const planes = range.map((k) => {
    const plane = new Uint8Array(texels);
    for (let i = 0, at = k; i < texels; i++, at += channels) plane[i] = codes[at] ?? 0;
    return plane;
  });
  return { planes: planes.map((plane, k) => halvesOfPlane(plane, scale[k] ?? 1, offset[k] ?? 0)), codes: { planes, scale, offset } };
}

/** The codes of all planes, if all are stored so. */
function codesOf(groups: LoadedGroup[]): FieldCodes | null {
  const all = groups.flatMap(({ codes }) => (codes ? [codes] : []));
  if (all.length !== groups.length || all.length === 0) return null;
  return { planes: all.flatMap(({ planes }) => planes), scale: all.flatMap(({ scale }) => scale), offset: all.flatMap(({ offset }) => offset) };
}

async function loadMap(map: ShareMap, texels: number, source: FileSource): Promise<FieldMap> {
  const bytes = await source(map.file);
  if (map.storage === "half") {
    const values = Float32Array.from(halves(await inflated([bytes], "gzip", 2 * texels)), fromHalf);
    if (values.length !== texels) throw new FieldError(`${map.file} has another size than the texture`);
    return { channels: 1, values };
  }
  const { codes, channels } = await decodePng(bytes, texels);
  if (codes.length !== channels * texels) throw new FieldError(`${map.file} has another size than the texture`);
  const values = new Float32Array(channels * texels);
  const scale = map.scale ?? 1 / 255, offset = map.offset ?? 0;
  for (let i = 0; i < texels; i++)
    for (let c = 0; c < channels; c++) values[c * texels + i] = scale * (codes[i * channels + c] ?? 0) + offset;
  return { channels: channels === 1 ? 1 : 3, values };
}

/** Little-endian half floats. */
function halves(bytes: Uint8Array): Uint16Array {
  return new Uint16Array(bytes.buffer, bytes.byteOffset, bytes.byteLength >> 1);
}
