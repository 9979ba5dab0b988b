import type { PageData } from "./page_data.ts";
import { bytes } from "./numbers.ts";

const FORMAT = "cranny-page/1";

/** Loads the data of this page: embedded if the page is one file, otherwise from the server. Throws an error whose
 * message can be shown unchanged. */
export async function loadPageData(): Promise<PageData> {
  const packed = document.getElementById("page-data")?.textContent?.trim() ?? "";
  const data: unknown = packed === "" ? await fetched() : JSON.parse(await unpacked(packed));
  const format = (data as { format?: unknown } | null)?.format;
  if (format !== FORMAT) {
    throw new Error(`This page shows data of the format ${FORMAT}, but these say ${JSON.stringify(format)}.`);
  }
  return data as PageData;
}

async function fetched(): Promise<unknown> {
  if (location.protocol === "file:") {
    throw new Error("There is nothing in this file to show; `cranny render ID PLAN -o out.html` writes one.");
  }
  const answer = await fetch("page.json");
  if (!answer.ok) throw new Error(`The server answers ${answer.status} to page.json.`);
  return answer.json();
}

/** Decodes base64(gzip(text)). */
export async function unpacked(packed: string): Promise<string> {
  const stream = new Blob([bytes(packed)]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).text();
}
