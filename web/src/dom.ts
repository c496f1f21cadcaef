type Attributes = Record<string, string | number | boolean | undefined>;

/** An element with attributes and children; text is never taken for markup. */
export function el<K extends keyof HTMLElementTagNameMap>(
  name: K,
  attributes: Attributes = {},
  ...children: (Node | string)[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(name);
  setAttributes(element, attributes);
  element.append(...children);
  return element;
}

const SVG = "http://www.w3.org/2000/svg";

/** As `el`, of SVG. */
export function svg(name: string, attributes: Attributes = {}, ...children: Node[]): SVGElement {
  const element = document.createElementNS(SVG, name);
  setAttributes(element, attributes);
  element.append(...children);
  return element;
}

function setAttributes(element: Element, attributes: Attributes): void {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === false) continue;
    element.setAttribute(name, value === true ? "" : String(value));
  }
}

/** An icon of lines in a square of 24. */
export function icon(path: string): SVGElement {
  const drawn = svg("path", { d: path, fill: "none", stroke: "currentColor", "stroke-width": 1.6, "stroke-linecap": "round", "stroke-linejoin": "round" });
  return svg("svg", { viewBox: "0 0 24 24", width: 20, height: 20, "aria-hidden": "true" }, drawn);
}

/** A button with an icon, and its name for screen readers and as a tooltip. */
export function iconButton(name: string, path: string, press: () => void): HTMLButtonElement {
  const button = el("button", { type: "button", class: "icon", "aria-label": name, title: name });
  button.append(icon(path));
  button.addEventListener("click", press);
  return button;
}

/** Saves bytes under a name. */
export function download(name: string, blob: Blob): void {
  const link = el("a", { download: name, href: URL.createObjectURL(blob) });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

/** A title as the name of a file. */
export function fileName(title: string): string {
  return title.replace(/[^\p{L}\p{N}._-]+/gu, "-") || "texture";
}
