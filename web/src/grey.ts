import type { Mode } from "relume-three";
import { D65, chromaticityOf } from "./balance.js";
import { shownParts } from "./parts.js";
import { linearColorAt } from "./pixels.js";
import { knowsMode } from "./stage.js";
import type { Viewer } from "./viewer.js";

/** Ways of showing whose colours are not those of the texture. */
const FALSE_COLOURS: readonly Mode[] = ["normals", "height", "slope", "shading"];
/** More than the grounds behind two pictures may differ where a texture covers them, in linear light. */
const COVERED = 1e-3;

/** The next place of the picture that is pressed is shown as neutral. */
export function pickGrey(viewer: Viewer, say: (sentence: string) => void): void {
  const take = (x: number, y: number): void => {
    const [black, white] = [colourAt(viewer, x, y, "#000"), colourAt(viewer, x, y, "#fff")], found = chromaticityOf(black);
    viewer.drawNow();
    if (hasFalseColours(viewer, x)) return again("There the colours are false: press a place as photographed, or Esc");
    if (black.some((value, i) => Math.abs(value - (white[i] ?? 0)) > COVERED)) return again("That place is beside the texture: press one on it, or Esc");
    if (!found) return again("That place is too dark to tell its colour: press another, or Esc");
    viewer.change({ whiteX: found[0], whiteY: found[1] });
  };
  const again = (sentence: string): void => {
    viewer.pick = take;
    viewer.redraw(false);
    say(sentence);
  };
  const { clientWidth } = viewer.canvas, ratio = viewer.canvas.width / clientWidth;
  if ([0, clientWidth - 1].every((x) => hasFalseColours(viewer, x * ratio))) return say("The picture has false colours: show it as photographed to pick a grey");
  again("Press a place of the picture that is grey, or Esc");
}

/** Whether a picture is shown with colours of its own, at a place across the canvas. */
function hasFalseColours({ state, stage, canvas }: Viewer, x: number): boolean {
  const parts = shownParts(state, (index) => stage.texture(index), canvas.clientWidth, canvas.clientHeight);
  const place = (x * canvas.clientWidth) / canvas.width, shown = parts.find(({ seen }) => place < seen.x + seen.width)?.state ?? state;
  return FALSE_COLOURS.includes(shown.mode) && knowsMode(stage.texture(shown.texture), shown.mode);
}

/** The linear colour at a place before it is balanced, where the texture lies on such a ground. */
function colourAt({ state, stage, canvas }: Viewer, x: number, y: number, ground: string): [number, number, number] {
  stage.draw({ ...state, whiteX: D65[0], whiteY: D65[1] }, ground);
  return linearColorAt(canvas, x, y);
}
