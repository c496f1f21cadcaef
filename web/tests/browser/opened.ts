import type { Browser, BrowserContextOptions, Page } from "playwright-core";
import { ready } from "./pictures.js";

export const USUAL: BrowserContextOptions = { viewport: { width: 700, height: 440 } };

/** Opens pages, and notes their errors and what they ask other hosts for. */
export class Opener {
  readonly complaints: string[] = [];

  constructor(private readonly browser: Browser) {}

  async open(url: string, options: BrowserContextOptions = USUAL): Promise<Page> {
    const page = await this.browser.newPage(options);
    page.on("console", (message) => ["error", "warning"].includes(message.type()) && !/GPU stall|software WebGL|performance/i.test(message.text()) && this.complaints.push(message.text()));
    page.on("pageerror", (error) => this.complaints.push(error.message));
    page.on("request", (request) => {
      if (!/^(http:\/\/(127\.0\.0\.1|localhost):|file:|data:|blob:)/.test(request.url())) this.complaints.push(`asked for ${request.url()}`);
    });
    await page.goto(url);
    await ready(page);
    return page;
  }

  /** What the browser writes about requests that fail is part of tests that make them fail. */
  forgiveFailedRequests(): void {
    const others = this.complaints.filter((one) => !/Failed to load resource/.test(one));
    this.complaints.splice(0, this.complaints.length, ...others);
  }
}
