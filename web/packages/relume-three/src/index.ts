/** Reflectance textures in three.js: texels that are functions of light and view. */
export { weights, hasClosedForm } from "./basis.js";
export { EnvironmentLamps } from "./environment.js";
export { loadMesh } from "./mesh.js";
export { MeasuredBasis } from "./measured.js";
export { BasisTable } from "./table.js";
export { type FieldBlocks, type FieldCells, type FieldData, type FieldLayout, type FieldMap, type FieldNoise, type FieldSpace, FieldError } from "./field.js";
export { type BlockMaker, EndlessTexture } from "./endless.js";
export { NoiseBlocks } from "./noise.js";
export { type PlaneRect, PlaneWindow } from "./window.js";
export { type ShareHeader, parseHeader } from "./header.js";
export { type TilePlace, TiledShare } from "./pyramid.js";
export { type FileSource, folderSource, loadShare, memorySource, openShare } from "./share.js";
export { loadPtm } from "./ptm.js";
export { loadRti } from "./rti.js";
export { type JpegDecoder, loadWebFolder } from "./web.js";
export { type GltfParser, REFLECTANCE_EXTENSION, ReflectanceGltf, glbSource } from "./gltf.js";
export { ReflectanceTexture } from "./texture.js";
export { ReflectanceMaterial, type ReflectanceLight, MODES, type Mode } from "./material.js";
