// The program under test, and files of its own material.
import { type ChildProcess, execFileSync, spawn } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { fileURLToPath } from "node:url";
import { join } from "node:path";

/** The program; RELUME names another build. */
export const PROGRAM = process.env["RELUME"] ?? fileURLToPath(new URL("../../target/release/relume", import.meta.url));

/** A folder for the files of a test, and the program run in it. */
export class Workplace {
  readonly folder = mkdtempSync(join(tmpdir(), "relume-web-"));

  run(command: string): string {
    return execFileSync(PROGRAM, command.split(" "), { cwd: this.folder, encoding: "utf8", stdio: ["ignore", "pipe", "pipe"] });
  }

  path(name: string): string {
    return join(this.folder, name);
  }

  remove(): void {
    rmSync(this.folder, { recursive: true, force: true });
  }
}

/** A running `relume view`. */
export class ViewServer {
  private constructor(private readonly process: ChildProcess, readonly url: string) {}

  static async start(place: Workplace, files: string[]): Promise<ViewServer> {
    const process = spawn(PROGRAM, ["view", ...files], { cwd: place.folder, stdio: ["ignore", "pipe", "pipe"] });
    const url = await new Promise<string>((resolve, reject) => {
      let text = "", errors = "";
      process.stderr.on("data", (part) => (errors += String(part)));
      process.stdout.on("data", (part) => {
        text += String(part);
        const found = /http:\S+/.exec(text);
        if (found) resolve(found[0]);
      });
      process.on("exit", () => reject(new Error(`relume view ended: ${errors}`)));
    });
    return new ViewServer(process, url);
  }

  /** Ends it as Ctrl-C does; gives the exit status. */
  async stop(): Promise<number | null> {
    const ended = new Promise<number | null>((resolve) => this.process.on("exit", (status) => resolve(status)));
    this.process.kill("SIGINT");
    return ended;
  }
}
