import { fileURLToPath } from "node:url";
import { defineConfig } from "vite";

const program = fileURLToPath(new URL("../crates/relume-cli/src/viewer/page/", import.meta.url));

// One classic script and one style sheet: a page that opens from disk cannot load modules.
export default defineConfig({
  resolve: {
    alias: { "relume-three": fileURLToPath(new URL("packages/relume-three/src/index.ts", import.meta.url)) },
  },
  build: {
    target: "es2022",
    outDir: program,
    emptyOutDir: false,
    modulePreload: false,
    copyPublicDir: false,
    lib: {
      entry: fileURLToPath(new URL("src/main.ts", import.meta.url)),
      formats: ["iife"],
      name: "RelumeViewer",
      fileName: () => "viewer.js",
      cssFileName: "viewer",
    },
  },
});
