import { type FileSource, folderSource, memorySource } from "relume-three";

/** A texture of the page: in a folder beside it, in the page itself, or one that could not be read. */
export interface PageTexture {
  title: string;
  folder?: string;
  files?: Record<string, string>;
  error?: string;
}

export interface PageData {
  title: string;
  textures: PageTexture[];
}

/** What the program wrote into the page. */
export function pageData(): PageData {
  const text = document.getElementById("relume-data")?.textContent ?? "";
  return JSON.parse(text) as PageData;
}

/** The files of a texture. */
export function sourceOf(texture: PageTexture): FileSource {
  if (texture.error !== undefined) throw new Error(texture.error);
  if (texture.files) return memorySource(texture.files);
  if (location.protocol === "file:") {
    throw new Error("browsers do not load files beside a page from disk: put this folder on a web server, or write one file with relume share --single-file");
  }
  return folderSource(new URL(texture.folder ?? "", location.href.split(/[?#]/)[0]).href);
}
