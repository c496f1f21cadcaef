// Validates every .glb and .ktx2 below the current folder with the programs of others.
import { readFileSync, readdirSync } from "node:fs";
import validator from "gltf-validator";
import { read } from "ktx-parse";
import { KTX2Loader } from "three/addons/loaders/KTX2Loader.js";

const files = readdirSync(".", { recursive: true }).filter((name) => !name.startsWith("node_modules"));
const of = (extension) => files.filter((name) => name.endsWith(extension));
let failed = 0;
const say = (name, problem) => {
  if (problem) failed++;
  console.log(`${problem ? "FAILED" : "ok"} ${name}${problem ? `: ${problem}` : ""}`);
};

for (const name of of(".glb")) {
  const report = await validator.validateBytes(new Uint8Array(readFileSync(name)), { ignoredIssues: ["UNSUPPORTED_EXTENSION"] });
  const { numErrors, numWarnings, messages } = report.issues;
  say(name, numErrors + numWarnings > 0 ? JSON.stringify(messages.filter((message) => message.severity < 2).slice(0, 3)) : "");
}

for (const name of of(".ktx2")) {
  try {
    const bytes = new Uint8Array(readFileSync(name));
    const file = read(bytes);
    const whole = Math.floor(Math.log2(Math.max(file.pixelWidth, file.pixelHeight))) + 1;
    if (file.levels.length !== whole) throw new Error(`${file.levels.length} levels, expected ${whole}`);
    const loader = new KTX2Loader();
    loader.workerConfig = {};
    const texture = await new Promise((resolve, reject) => loader.parse(bytes.buffer, resolve, reject));
    const base = texture.mipmaps?.[0] ?? texture.image;
    if (base.width !== file.pixelWidth) throw new Error(`three finds ${base.width} texels across`);
    say(name, "");
  } catch (error) {
    say(name, error.message ?? String(error));
  }
}
if (of(".glb").length === 0 || of(".ktx2").length === 0) say("nothing was found to validate", "no files");
process.exit(failed > 0 ? 1 : 0);
