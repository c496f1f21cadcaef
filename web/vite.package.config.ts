import { fileURLToPath } from "node:url";
import { defineConfig } from "vite";

const from = (path: string): string => fileURLToPath(new URL(`packages/relume-three/${path}`, import.meta.url));

// The package: a module for each file, so that programs take what they use, without what only people read.
export default defineConfig({
  build: {
    target: "es2022",
    outDir: from("dist"),
    emptyOutDir: true,
    minify: false,
    lib: { entry: from("src/index.ts"), formats: ["es"] },
    rolldownOptions: {
      external: ["three"],
      output: {
        preserveModules: true,
        entryFileNames: "[name].js",
        minify: { compress: false, mangle: false, codegen: { removeWhitespace: true } },
      },
    },
  },
});
