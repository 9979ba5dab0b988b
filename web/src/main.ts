import "./style/base.css";
import "./style/frame.css";
import "./style/panel.css";
import "./style/stages.css";
import "./style/time_line.css";
import "./style/over_scene.css";
import "./style/small_screens.css";
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
