// `<relume-view src="texture/">` shows a page that `relume share` wrote within another page.

const SHEET = ":host { display: block; aspect-ratio: 3 / 2; } :host([hidden]) { display: none; } iframe { display: block; width: 100%; height: 100%; border: 0; }";

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
    const src = this.getAttribute("src");
    if (src === null) return this.frame.removeAttribute("src");
    const url = new URL(src, document.baseURI), view = this.getAttribute("view");
    if (view !== null) url.hash = view;
    // A change of the view alone moves the page that is there.
    if (this.frame.src !== url.href) this.frame.src = url.href;
  }
}

customElements.define("relume-view", RelumeView);
