import { readdirSync, rmSync } from "node:fs";
import type { Browser, BrowserContextOptions, Page } from "playwright-core";
import { afterAll, afterEach, beforeAll, expect } from "vitest";
import { launched } from "../chromium.js";
import { ViewServer, Workplace } from "../program.js";
import { ready } from "./pictures.js";

export const USUAL: BrowserContextOptions = { viewport: { width: 700, height: 440 } };
/** A small texture, leather.ptm. */
export const LEATHER = ["capture leather -o capture --lights 16 --size 128x96 --feature 32", "fit capture -o leather.ptm"];
/** A small model whose plane has no end, marble.rlm. */
export const MARBLE = ["procedural marble -o marble --size 64 --feature 9", "model marble/albedo.png -o marble.rlm --combine never"];

/** Opens pages, and notes their errors and what they ask other hosts for. */
export class Opener {
  readonly complaints: string[] = [];

  constructor(private readonly browser: () => Browser) {}

  async open(url: string, options: BrowserContextOptions = USUAL): Promise<Page> {
    const page = await this.blank(options);
    await page.goto(url);
    await ready(page);
    return page;
  }

  /** A page that shows nothing yet. */
  async blank(options: BrowserContextOptions = USUAL): Promise<Page> {
    const page = await this.browser().newPage(options);
    page.on("console", (message) => ["error", "warning"].includes(message.type()) && !/GPU stall|software WebGL|performance/i.test(message.text()) && this.complaints.push(message.text()));
    page.on("pageerror", (error) => this.complaints.push(error.message));
    page.on("request", (request) => {
      if (!/^(http:\/\/(127\.0\.0\.1|localhost):|file:|data:|blob:)/.test(request.url())) this.complaints.push(`asked for ${request.url()}`);
    });
    return page;
  }

  /** What the browser writes about requests that fail is part of tests that make them fail. */
  forgiveFailedRequests(): void {
    const others = this.complaints.filter((one) => !/Failed to load resource/.test(one));
    this.complaints.splice(0, this.complaints.length, ...others);
  }
}

/** The files, the server and the browser of the tests of a file. */
export class Session {
  readonly place = new Workplace();
  readonly opener = new Opener(() => this.browser);
  private running: Browser | null = null;
  private served: ViewServer | null = null;

  /** The browser, once the tests run. */
  get browser(): Browser {
    if (!this.running) throw new Error("the browser is not there yet");
    return this.running;
  }

  /** The address of the page. */
  get url(): string {
    return this.served?.url ?? "";
  }

  async begin(prepare: readonly string[], show: string[]): Promise<void> {
    for (const command of prepare) this.place.run(command);
    if (show.length > 0) this.served = await ViewServer.start(this.place, show);
    this.running = await launched();
  }

  async end(): Promise<void> {
    await this.running?.close();
    if (this.served) expect(await this.served.stop()).toBe(130);
    this.place.remove();
  }
}

/**
 * Before the tests of a file, runs commands of the program and serves what they made; after each, no page may have complained, and what
 * was written about the textures is gone.
 */
export function session(prepare: readonly string[], show: string[], more: (place: Workplace) => Promise<void> | void = () => undefined): Session {
  const session = new Session();
  beforeAll(async () => {
    await more(session.place);
    await session.begin(prepare, show);
  });
  afterAll(() => session.end());
  afterEach(() => {
    for (const name of readdirSync(session.place.folder)) if (name.endsWith(".annotations.json")) rmSync(session.place.path(name), { force: true });
    expect(session.opener.complaints.splice(0)).toEqual([]);
  });
  return session;
}
