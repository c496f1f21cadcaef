import { type FlatPlaces, flatPlaces, pictureAt, placesUnder, texelAt } from "./places.js";
import { type ViewState, onDisk } from "./state.js";
import type { Viewer } from "./viewer.js";

/** Pixels around the border of a wipe at which it is taken. */
const GRIP = 14;

type Drag = "light" | "move" | "wipe" | "tool";

/** Draws in the flat picture with what moves the light otherwise. */
export interface DrawingTool {
  begin(event: PointerEvent): void;
  move(event: PointerEvent): void;
  end(): void;
  /** A second finger came: the drag is none of the tool's. */
  cancel(): void;
}

/**
 * Moves light and view by the pointer: the first button or one finger moves the light, or the view where that was chosen, or draws
 * with a tool; the other buttons, Shift, or two fingers move the view; wheel and pinch magnify.
 */
export function listen(canvas: HTMLCanvasElement, viewer: Viewer): void {
  const touches = new Map<number, PointerEvent>();
  let drag: Drag | null = null;
  canvas.addEventListener("pointerdown", (event) => {
    if (viewer.pick) {
      const box = canvas.getBoundingClientRect(), ratio = canvas.width / box.width, take = viewer.pick;
      viewer.pick = null;
      viewer.redraw(false);
      return take(Math.round((event.clientX - box.left) * ratio), Math.round((event.clientY - box.top) * ratio));
    }
    canvas.setPointerCapture(event.pointerId);
    touches.set(event.pointerId, event);
    if (drag === "tool") viewer.tool?.cancel();
    drag = touches.size > 1 ? "move" : dragOf(event, canvas, viewer);
    if (drag === "tool") return viewer.tool?.begin(event);
    viewer.begin();
    if (drag === "light") moveLight(event, canvas, viewer);
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = touches.get(event.pointerId);
    if (!before) {
      canvas.style.cursor = nearWipe(event, canvas, viewer) ? "ew-resize" : "";
      return;
    }
    if (drag === "tool") viewer.tool?.move(event);
    else if (touches.size === 2) pinch(touches, event, canvas, viewer);
    else if (drag === "light") moveLight(event, canvas, viewer);
    else if (drag === "wipe") viewer.change({ wipe: clamp01((event.clientX - canvas.getBoundingClientRect().left) / canvas.clientWidth) }, "wipe");
    else pan(event.clientX - before.clientX, event.clientY - before.clientY, event, viewer);
    touches.set(event.pointerId, event);
  });
  for (const name of ["pointerup", "pointercancel"] as const) {
    canvas.addEventListener(name, (event) => {
      touches.delete(event.pointerId);
      const ended = drag;
      drag = null;
      if (ended !== "tool") return;
      if (name === "pointerup") viewer.tool?.end();
      else viewer.tool?.cancel();
    });
  }
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("dblclick", () => {
    if (!viewer.tool) viewer.fit();
  });
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    magnify(Math.exp(-event.deltaY / (event.ctrlKey ? 100 : 500)), event, canvas, viewer);
  }, { passive: false });
}

function dragOf(event: PointerEvent, canvas: HTMLCanvasElement, viewer: Viewer): Drag {
  if (nearWipe(event, canvas, viewer)) return "wipe";
  const other = event.button !== 0 || event.shiftKey || event.altKey;
  if (other !== viewer.movesView) return "move";
  return viewer.tool && placesUnder(event, viewer) ? "tool" : "light";
}

function nearWipe(event: PointerEvent, canvas: HTMLCanvasElement, viewer: Viewer): boolean {
  const { compare, wipe } = viewer.state;
  const place = event.clientX - canvas.getBoundingClientRect().left;
  return (compare === "wipe" || compare === "plain") && Math.abs(place - wipe * canvas.clientWidth) < GRIP;
}

/** The light is over the place of the pointer, on a disk as high as the picture. */
function moveLight(event: PointerEvent, canvas: HTMLCanvasElement, viewer: Viewer): void {
  const box = canvas.getBoundingClientRect(), half = Math.min(box.width, box.height) / 2;
  const [u, v] = onDisk((event.clientX - box.left - box.width / 2) / half, (box.top + box.height / 2 - event.clientY) / half);
  viewer.lamps.change({ u, v }, false);
}

/** Moves the flat texture at a place of the screen with the pointer, or turns the object. */
export function pan(dx: number, dy: number, at: { clientX: number }, viewer: Viewer): void {
  const { state } = viewer, places = placesUnder(at, viewer);
  if (places) return viewer.change(moved(state, [-dx / places.scale, -dy / places.scale], places), "move");
  const elevation = Math.min(90, Math.max(-90, state.elevation + dy * 0.4));
  viewer.change({ azimuth: state.azimuth - dx * 0.4, elevation }, "move");
}

/** Magnifies about a place of the screen. */
export function magnify(factor: number, at: { clientX: number; clientY: number }, canvas: HTMLCanvasElement, viewer: Viewer): void {
  const { state } = viewer, places = flatPlaces(viewer);
  const picture = pictureAt(places, at.clientX - canvas.getBoundingClientRect().left), before = places[picture];
  if (!before) return viewer.change({ near: Math.min(50, Math.max(0.05, state.near * factor)) }, "zoom");
  const zoom = Math.min(4096, Math.max(0.02, state.zoom * factor));
  const after = flatPlaces(viewer, { ...state, zoom })[picture] ?? before;
  const [x, y] = texelAt(at, canvas, before), [toX, toY] = texelAt(at, canvas, after);
  viewer.change({ zoom, ...moved(state, [x - toX, y - toY], before) }, "zoom");
}

/** The middle of the view once that of a picture has moved by so many texels. */
function moved({ x, y }: ViewState, texels: [number, number], { size, pace }: FlatPlaces): Pick<ViewState, "x" | "y"> {
  return { x: x + texels[0] / size[0] / pace[0], y: y + texels[1] / size[1] / pace[1] };
}

/** Two fingers: their middle moves the view, their distance magnifies it. */
function pinch(touches: Map<number, PointerEvent>, event: PointerEvent, canvas: HTMLCanvasElement, viewer: Viewer): void {
  const other = [...touches.values()].find((touch) => touch.pointerId !== event.pointerId);
  const before = touches.get(event.pointerId);
  if (!other || !before) return;
  const distance = (touch: PointerEvent): number => Math.hypot(touch.clientX - other.clientX, touch.clientY - other.clientY);
  const middle = { clientX: (event.clientX + other.clientX) / 2, clientY: (event.clientY + other.clientY) / 2 };
  pan((event.clientX - before.clientX) / 2, (event.clientY - before.clientY) / 2, middle, viewer);
  if (distance(before) > 1) magnify(distance(event) / distance(before), middle, canvas, viewer);
}

function clamp01(value: number): number {
  return Math.min(1, Math.max(0, value));
}
