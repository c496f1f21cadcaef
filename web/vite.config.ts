import { fileURLToPath } from "node:url";
import { defineConfig } from "vite";

const program = fileURLToPath(new URL("../crates/relume-cli/src/viewer/page/", import.meta.url));
/** The page, and the element that shows it in other pages: entry, file, and name within the script. */
const SCRIPTS: Record<string, [string, string, string]> = {
  production: ["src/main.ts", "viewer.js", "RelumeViewer"],
  element: ["src/element.ts", "relume-view.js", "RelumeElement"],
};

// Classic scripts and one style sheet: a page that opens from disk cannot load modules.
export default defineConfig(({ mode }) => {
  const [entry, file, name] = SCRIPTS[mode] ?? ["src/main.ts", "viewer.js", "RelumeViewer"];
  return {
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
        entry: fileURLToPath(new URL(entry, import.meta.url)),
        formats: ["iife"],
        name,
        fileName: () => file,
        cssFileName: "viewer",
      },
    },
  };
});
