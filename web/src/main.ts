import "./style.css";
import { Bookmarks, bookmarkKey } from "./bookmarks.js";
import { el } from "./dom.js";
import { listenForFiles } from "./dropped.js";
import { Loading } from "./loading.js";
import { Notes } from "./notes.js";
import { Notice } from "./notice.js";
import { pageData } from "./page.js";
import { Panel } from "./panel.js";
import { listen, magnify, pan } from "./pointer.js";
import { Ruler } from "./ruler.js";
import { OBJECTS } from "./state.js";
import { Toolbar } from "./tools.js";
import { Viewer } from "./viewer.js";

const MAKING = "The first picture of this way of showing is being made: of many functions that takes a while.";
const LOST = "The graphics card has taken the picture away: it is drawn again as soon as the browser gives it back, and nothing can be saved until then.";

function start(): void {
  const { title, textures, mesh } = pageData();
  const canvas = el("canvas", { tabindex: 0, role: "application", "aria-label": `${title}: drag, or press the arrow keys, to move the light` });
  const notice = new Notice(), picture = el("div", { class: "picture" }, canvas);
  const foot = el("div", { class: "foot" }, notice.element), stage = el("div", { class: "stage" }, picture, foot);
  const main = el("main", {}, el("h1", { class: "hidden" }, title), stage);
  document.body.append(main);
  let viewer: Viewer;
  try {
    viewer = new Viewer(canvas, textures);
  } catch {
    notice.say(["This browser does not draw with WebGL 2: enable it, or open the page in another browser."]);
    return;
  }
  const say = (sentence: string): void => tools.say(sentence);
  const panel = new Panel(viewer, say), ruler = new Ruler(viewer), notes = new Notes(viewer, textures, say);
  panel.element.append(notes.section);
  panel.element.hidden = matchMedia("(max-width: 640px)").matches;
  const bookmarks = new Bookmarks(viewer, notes, bookmarkKey(location, title, viewer.titles), say);
  const tools = new Toolbar(viewer, panel.element, ruler, bookmarks);
  const wipe = el("div", { class: "wipe", "aria-hidden": "true" });
  picture.append(notes.element, ruler.element, ruler.bars, wipe);
  main.append(panel.element);
  foot.append(tools.element);
  const loading = new Loading(viewer, textures, notes, mesh ?? null, notice);
  const failures = (): string[] => [...viewer.failures, ...loading.failures];
  viewer.onChange(() => {
    panel.refresh(viewer.state);
    ruler.refresh();
    notes.refresh();
    wipe.hidden = !["wipe", "plain"].includes(viewer.state.compare);
    wipe.style.left = `${100 * viewer.state.wipe}%`;
    picture.classList.toggle("drawing", viewer.tool !== null && viewer.state.object === "flat" && !viewer.movesView);
    if (document.documentElement.dataset["ready"] === undefined && !viewer.isLost) return;
    const making = viewer.stage.making.isLong ? [MAKING] : [];
    const coming = viewer.stage.pending > 0 ? [`${viewer.stage.pending} tiles to come`] : [];
    const wrong = [...(viewer.isLost ? [LOST] : []), ...failures().map((sentence) => `${sentence}. The page tries again.`), ...notes.failures];
    notice.say(wrong.length > 0 ? wrong : [...making, ...coming]);
  });
  viewer.retryWhile(() => failures().length > 0 || notes.isWaiting, () => {
    viewer.stage.retry();
    notes.retry();
    if (loading.failures.length > 0) void loading.run();
  });
  listen(canvas, viewer);
  listenForFiles(viewer, say);
  canvas.addEventListener("keydown", (event) => viewer.lamps.moveByKey(event));
  addEventListener("keydown", (event) => pressed(event, { viewer, tools, ruler, notes, bookmarks }));
  void loading.run();
  viewer.redraw();
}

/** What keys act on. */
interface Controls {
  viewer: Viewer;
  tools: Toolbar;
  ruler: Ruler;
  notes: Notes;
  bookmarks: Bookmarks;
}

/** Turns off the tool that draws, or the choice of a place. */
function endDrawing({ viewer, ruler, notes }: Controls): void {
  if (viewer.pick) {
    viewer.pick = null;
    viewer.redraw(false);
  } else if (viewer.tool === ruler) ruler.toggle();
  else if (viewer.tool === notes) notes.toggle();
}

/** Keys that act wherever the focus is, but for fields of text. */
function pressed(event: KeyboardEvent, controls: Controls): void {
  const { viewer, tools, ruler, notes, bookmarks } = controls;
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
    escape: () => endDrawing(controls),
    m: () => viewer.nextMode(),
    o: () => viewer.lamps.toggleOrbit(),
    r: () => ruler.toggle(),
    s: () => void tools.snapshot(),
    n: () => notes.writeAtMiddle(),
    b: () => bookmarks.open(),
    h: () => tools.toggleControls(),
    "0": () => viewer.fit(),
    "+": () => magnify(1.25, center, canvas, viewer),
    "=": () => magnify(1.25, center, canvas, viewer),
    "-": () => magnify(0.8, center, canvas, viewer),
  };
  if (shift && event.shiftKey) return pan(shift[0], shift[1], center, viewer);
  if (object && (object !== "mesh" || viewer.stage.mesh)) return viewer.change({ object });
  const act = actions[key];
  if (!act) return;
  // The letter would be written into a dialog that opens.
  event.preventDefault();
  act();
}

start();
