import "./style.css";
import { el } from "./dom.js";
import { listenForFiles } from "./dropped.js";
import { loadMesh } from "relume-three";
import { Notes } from "./notes.js";
import { type PageMesh, type PageTexture, meshBytes, pageData } from "./page.js";
import { Panel } from "./panel.js";
import { listen, magnify, pan } from "./pointer.js";
import { Ruler } from "./ruler.js";
import { OBJECTS } from "./state.js";
import { Toolbar } from "./tools.js";
import { Viewer } from "./viewer.js";

function start(): void {
  const { title, textures, mesh } = pageData();
  const canvas = el("canvas", { tabindex: 0, role: "application", "aria-label": `${title}: drag, or press the arrow keys, to move the light` });
  const notice = el("div", { class: "notice", role: "status" });
  const foot = el("div", { class: "foot" }, notice), stage = el("div", { class: "stage" }, canvas, foot);
  const main = el("main", {}, el("h1", { class: "hidden" }, title), stage);
  document.body.append(main);
  let viewer: Viewer;
  try {
    viewer = new Viewer(canvas, textures);
  } catch {
    notice.textContent = "This browser does not draw with WebGL 2: enable it, or open the page in another browser.";
    return;
  }
  const say = (sentence: string): void => tools.say(sentence);
  const panel = new Panel(viewer, say), ruler = new Ruler(viewer), notes = new Notes(viewer, textures, say);
  panel.element.append(notes.section);
  panel.element.hidden = matchMedia("(max-width: 640px)").matches;
  const tools = new Toolbar(viewer, title, panel.element, ruler);
  const wipe = el("div", { class: "wipe", "aria-hidden": "true" });
  stage.append(notes.element, ruler.element, ruler.bar, wipe);
  main.append(panel.element);
  foot.append(tools.element);
  const failures = (): string[] => [...viewer.failures, ...notes.failures];
  viewer.onChange(() => {
    panel.refresh(viewer.state);
    ruler.refresh();
    notes.refresh();
    wipe.hidden = !["wipe", "plain"].includes(viewer.state.compare);
    stage.classList.toggle("drawing", viewer.tool !== null && viewer.state.object === "flat" && !viewer.movesView);
    if (document.documentElement.dataset["ready"] !== undefined) {
      const coming = viewer.stage.pending > 0 ? [`${viewer.stage.pending} tiles to come`] : [];
      const wrong = failures().map((sentence) => `${sentence}. The page tries again.`);
      const text = [notice.dataset["errors"] ?? "", ...(wrong.length > 0 ? wrong : coming)].filter((line) => line !== "").join("\n");
      // Screen readers would say it again.
      if (notice.textContent !== text) notice.textContent = text;
    }
    wipe.style.left = `${100 * viewer.state.wipe}%`;
  });
  viewer.retryWhile(() => failures().length > 0, () => {
    viewer.stage.retry();
    notes.retry();
  });
  listen(canvas, viewer);
  listenForFiles(viewer, say);
  canvas.addEventListener("keydown", (event) => viewer.moveByKey(event));
  addEventListener("keydown", (event) => pressed(event, viewer, tools, ruler, title, notes));
  void loadAll(viewer, textures, notice, mesh ?? null, notes);
  viewer.redraw();
}

/** Loads the texture of the view first, then the others. */
async function loadAll(viewer: Viewer, textures: PageTexture[], notice: HTMLElement, mesh: PageMesh | null, notes: Notes): Promise<void> {
  const order = textures.map((_, i) => i).sort((a, b) => Number(b === viewer.state.texture) - Number(a === viewer.state.texture));
  const errors: string[] = [];
  for (const i of order) {
    const texture = textures[i];
    if (!texture) continue;
    // What still comes in after a file failed says nothing.
    let isLoading = true;
    const progress = (share: number): void => {
      if (isLoading) notice.textContent = `${texture.title}: ${Math.round(100 * share)} %`;
    };
    try {
      await viewer.load(i, texture, progress);
      document.documentElement.dataset["loaded"] = String(Number(document.documentElement.dataset["loaded"] ?? 0) + 1);
    } catch (error) {
      errors.push(`${texture.title}: ${error instanceof Error ? error.message : String(error)}`);
    } finally {
      isLoading = false;
    }
  }
  const said = (error: unknown): string => (error instanceof Error ? error.message : String(error));
  await notes.load().catch((error: unknown) => errors.push(`annotations: ${said(error)}`));
  try {
    if (mesh) viewer.setObject(mesh.title, await loadMesh(await meshBytes(mesh)));
  } catch (error) {
    errors.push(`${mesh?.title ?? ""}: ${said(error)}`);
  }
  viewer.redraw();
  notice.textContent = notice.dataset["errors"] = errors.join("\n");
  document.documentElement.dataset["ready"] = String(errors.length);
}

/** Turns off the tool that draws. */
function endDrawing(viewer: Viewer, ruler: Ruler, notes: Notes): void {
  if (viewer.tool === ruler) ruler.toggle();
  else if (viewer.tool === notes) notes.toggle();
}

/** Keys that act wherever the focus is, but for fields of text. */
function pressed(event: KeyboardEvent, viewer: Viewer, tools: Toolbar, ruler: Ruler, title: string, notes: Notes): void {
  const target = event.target as HTMLElement | null;
  // What is written has an undo of its own; keys of other controls are theirs.
  if (target?.closest("textarea, dialog, input:not([type=range], [type=checkbox], [type=color])")) return;
  const key = event.key.toLowerCase();
  if (event.ctrlKey || event.metaKey) {
    if (key === "z" && !event.shiftKey) viewer.undo();
    else if (key === "y" || key === "z") viewer.redo();
    else return;
    event.preventDefault();
    return;
  }
  if (target?.closest("input, select")) return;
  const { canvas } = viewer, middle = canvas.getBoundingClientRect();
  const center = { clientX: middle.left + viewer.viewWidth(middle.width) / 2, clientY: middle.top + middle.height / 2 };
  const shifts: Record<string, [number, number]> = { arrowleft: [30, 0], arrowright: [-30, 0], arrowup: [0, 30], arrowdown: [0, -30] };
  const shift = shifts[key];
  const object = OBJECTS[Number(key) - 1];
  const actions: Record<string, () => void> = {
    escape: () => endDrawing(viewer, ruler, notes),
    m: () => viewer.nextMode(),
    o: () => viewer.toggleOrbit(),
    r: () => ruler.toggle(),
    s: () => void tools.snapshot(title),
    n: () => notes.writeAtMiddle(),
    b: () => tools.openBookmarks(),
    h: () => tools.toggleControls(),
    "0": () => viewer.fit(),
    "+": () => magnify(1.25, center, canvas, viewer),
    "=": () => magnify(1.25, center, canvas, viewer),
    "-": () => magnify(0.8, center, canvas, viewer),
  };
  if (shift && event.shiftKey) return pan(shift[0], shift[1], canvas, viewer);
  if (object && (object !== "mesh" || viewer.stage.mesh)) return viewer.change({ object });
  const act = actions[key];
  if (!act) return;
  // The letter would be written into a dialog that opens.
  event.preventDefault();
  act();
}

start();
