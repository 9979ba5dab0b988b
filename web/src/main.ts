import "./style.css";
import { element } from "./panels/element.ts";
import { openPage } from "./data/page.ts";
import { loadPageData } from "./data/page_source.ts";

const host = document.getElementById("page") ?? document.body;
try {
  openPage(host, await loadPageData());
} catch (error) {
  const message = error instanceof Error ? error.message : String(error);
  const hint = /webgl/i.test(message) ? "This page draws with WebGL 2, which this browser does not offer. " : "";
  host.replaceChildren(
    element(
      "div",
      { class: "failure", role: "alert" },
      element("h1", {}, "Nothing to see"),
      element("p", {}, hint + message),
    ),
  );
  console.error(error);
}
