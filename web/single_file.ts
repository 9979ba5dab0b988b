import type { Plugin } from "vite";

/** Writes `single.html` next to `index.html`: the same page with script and style embedded, so that it can be opened
 * from disk after its data are inserted into the element `page-data`. */
export function singleFile(): Plugin {
  return {
    name: "cranny-single-file",
    enforce: "post",
    generateBundle(_options, bundle) {
      const page = bundle["index.html"];
      if (page?.type !== "asset") throw new Error("no index.html in the bundle");
      const source = (name: string): string => {
        const part = bundle[name.replace(/^\.\//, "")];
        if (!part) throw new Error(`index.html names ${name}, which is not in the bundle`);
        return part.type === "chunk" ? part.code : String(part.source);
      };
      const html = String(page.source)
        .replace(/<script type="module"[^>]* src="([^"]+)"><\/script>/g, (_all, name: string) => {
          // No closing tag inside the code may end the element.
          const code = source(name).replace(/<\/(script)/gi, "<\\/$1");
          return `<script type="module">${code}</script>`;
        })
        .replace(/<link rel="stylesheet"[^>]* href="([^"]+)">/g, (_all, name: string) => {
          return `<style>${source(name).replace(/<\/(style)/gi, "<\\/$1")}</style>`;
        });
      if (/\s(src|href)="(?!data:|#)/.test(html.replace(/<script type="module">[\s\S]*?<\/script>/g, ""))) {
        throw new Error("single.html would still load something");
      }
      this.emitFile({ type: "asset", fileName: "single.html", source: html });
    },
  };
}
