import { fileURLToPath } from "node:url";
import { defineConfig } from "vitest/config";

export default defineConfig({
  resolve: { alias: { "relume-three": fileURLToPath(new URL("packages/relume-three/src/index.ts", import.meta.url)) } },
  test: {
    projects: [
      { extends: true, test: { name: "unit", include: ["packages/*/tests/*.test.ts", "tests/unit/*.test.ts"] } },
      {
        extends: true,
        test: { name: "browser", include: ["tests/browser/*.test.ts"], testTimeout: 240_000, hookTimeout: 480_000, fileParallelism: false },
      },
      {
        extends: true,
        test: { name: "pictures", include: ["tests/documentation/*.ts"], testTimeout: 600_000, hookTimeout: 600_000 },
      },
    ],
  },
});
