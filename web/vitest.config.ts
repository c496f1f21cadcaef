import { fileURLToPath } from "node:url";
import { defineConfig } from "vitest/config";

/** Tests with browsers, which a busy machine keeps waiting. */
const SLOW = { testTimeout: 240_000, hookTimeout: 480_000, expect: { poll: { timeout: 10_000 } } };
/** Tests of how long something takes: nothing runs beside them. */
const TIMED = ["tests/browser/tiles.test.ts"];

export default defineConfig({
  resolve: { alias: { "relume-three": fileURLToPath(new URL("packages/relume-three/src/index.ts", import.meta.url)) } },
  test: {
    projects: [
      { extends: true, test: { name: "unit", include: ["packages/*/tests/*.test.ts", "tests/unit/*.test.ts"] } },
      {
        extends: true,
        // Two files at a time: most of what they do is to wait for a page.
        test: { name: "browser", include: ["tests/browser/*.test.ts"], exclude: TIMED, ...SLOW, maxWorkers: 2, sequence: { groupOrder: 0 } },
      },
      {
        extends: true,
        test: { name: "timed", include: TIMED, ...SLOW, fileParallelism: false, sequence: { groupOrder: 1 } },
      },
      {
        extends: true,
        test: { name: "pictures", include: ["tests/documentation/*.ts"], testTimeout: 600_000, hookTimeout: 600_000 },
      },
    ],
  },
});
