// `<relume-view src="texture/">` shows a page that `relume share` wrote within another page.

const SHEET = ":host { display: block; aspect-ratio: 3 / 2; } :host([hidden]) { display: none; } iframe { display: block; width: 100%; height: 100%; border: 0; }";

/** What can hold a page. */
const PAGES = ["http:", "https:", "file:"];

/** Attributes: `src`, the folder or the HTML file; `view`, the part of an address after #; `title`, for screen readers. */
export class RelumeView extends HTMLElement {
  static readonly observedAttributes = ["src", "view", "title"];
  private readonly frame = document.createElement("iframe");

  constructor() {
    super();
    const root = this.attachShadow({ mode: "open" }), sheet = new CSSStyleSheet();
    sheet.replaceSync(SHEET);
    root.adoptedStyleSheets = [sheet];
    this.frame.loading = "lazy";
    this.frame.allow = "fullscreen";
    root.append(this.frame);
  }

  attributeChangedCallback(): void {
    this.frame.title = this.getAttribute("title") ?? "Texture under moving light";
    const url = addressOf(this.getAttribute("src"));
    if (!url) return this.frame.removeAttribute("src");
    const view = this.getAttribute("view");
    if (view !== null) url.hash = view;
    // A change of the view alone moves the page that is there.
    if (this.frame.src !== url.href) this.frame.src = url.href;
  }
}

/** The address of a page; none of anything else, since that of a script would run in the page around. */
function addressOf(src: string | null): URL | null {
  try {
    const url = src === null ? null : new URL(src, document.baseURI);
    return url && PAGES.includes(url.protocol) ? url : null;
  } catch {
    return null;
  }
}

customElements.define("relume-view", RelumeView);
