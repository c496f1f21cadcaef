import { type FileSource, folderSource, memorySource } from "relume-three";

/** A texture of the page: in a folder beside it, in the page itself, or one that could not be read. */
export interface PageTexture {
  title: string;
  folder?: string;
  files?: Record<string, string>;
  /** Whether it comes with light from all around. */
  environment?: boolean;
  /** Where annotations are read and written. */
  notes?: string | null;
  /** Annotations of a page that writes none. */
  annotations?: unknown;
  error?: string;
}

export interface PageData {
  title: string;
  textures: PageTexture[];
  mesh?: PageMesh | null;
}

/** The user's own object. */
export interface PageMesh {
  title: string;
  file?: string;
  bytes?: string;
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
  return folderSource(besidePage(texture.folder ?? ""));
}

/** The address of a file beside the page. */
export function besidePage(name: string): string {
  return new URL(name, location.href.split(/[?#]/)[0]).href;
}

/** The bytes of the user's own object. */
export async function meshBytes({ file, bytes }: PageMesh): Promise<Uint8Array> {
  if (bytes !== undefined) return memorySource({ mesh: bytes })("mesh");
  return folderSource(besidePage(""))(file ?? "");
}
