import * as colours from "../colours.ts";
import { CameraFlight } from "../camera_flight.ts";
import { Carrying } from "../motion/carrying.ts";
import { progress } from "../figures.ts";
import { STANDARD_VIEWS } from "../framing.ts";
import { fewGrasps } from "../panels/grasp_choice.ts";
import { GraspPanel } from "../panels/grasp_panel.ts";
import { GraspTip } from "../motion/grasp_tip.ts";
import { Help } from "../panels/help.ts";
import { openInspection } from "../inspection.ts";
import { JointPanel } from "../panels/joint_panel.ts";
import { listenToKeys } from "../panels/keyboard.ts";
import { Kinematics } from "../motion/kinematics.ts";
import { LayerPanel } from "../panels/layer_panel.ts";
import { LinkKeeper } from "./link_keeper.ts";
import { LiveVerdict } from "./live_verdict.ts";
import type { PageData } from "./page_data.ts";
import { followFeed } from "./page_feed.ts";
import { Player } from "../motion/player.ts";
import { PlanPanel } from "../panels/plan_panel.ts";
import { Recording } from "./recording.ts";
import { SceneView } from "../views/scene_view.ts";
import { Shell } from "../panels/shell.ts";
import { Stage } from "../stage.ts";
import { StagePanel } from "../panels/stage_panel.ts";
import { Theme } from "../theme.ts";
import { TimeLine } from "../panels/time_line.ts";
import { ClearanceCurve, type ShownPlan, Trajectory } from "../motion/trajectory.ts";
import { TreePanel } from "../panels/tree_panel.ts";
import { Film } from "../film.ts";
import { fromHash } from "./view_link.ts";
import { INITIAL, type Layer, View, type ViewState } from "./view_state.ts";

/** The system's setting for reduced motion. */
const STILL = matchMedia("(prefers-reduced-motion: reduce)");

/** Builds the page: one scene, one view of it, and the panels that change the view. */
export function openPage(host: HTMLElement, data: PageData): void {
  // 1. The content.
  const root = data.robot.links.findIndex(({ parent }) => parent === null);
  const kinematics = new Kinematics(data.robot, data.nodes[root]?.parent_from_node);
  const plans = shownPlans(data, kinematics);
  const recording = data.recording ? new Recording(data.recording) : null;
  const reasons = [...new Set(plans.flatMap(({ reasons }) => [...reasons.values()]))].filter(
    (reason) => reason !== colours.NOT_TRIED,
  );
  const available = availableLayers(data, plans);
  const asked = fromHash(location.hash);
  const view = new View(firstView(data, plans, recording, reasons, asked));

  // 2. The scene.
  const theme = new Theme();
  const shell = new Shell(data, plans);
  host.replaceChildren(shell.element);
  const stage = new Stage(shell.viewport);
  shell.onInsets((insets) => stage.setInsets(insets));
  const movers = { nodes: data.nodes, plans, kinematics, recording };
  const scene = new SceneView(data, movers, { stage, view, reasons });
  theme.on((palette, name) => scene.setTheme(palette, name));
  scene.onSeenThrough = (names) => shell.captionSeenThrough(names);
  const player = new Player(view, stage, plans, recording);
  const flight = new CameraFlight(stage, view);
  const live = new LiveVerdict(data.is_live);

  // 3. The panels.
  const timeLine = new TimeLine(view, player, plans, theme);
  shell.dock.append(timeLine.element);
  const parts: HTMLElement[] = [];
  if (plans.length > 0) parts.push(new PlanPanel(view, plans).element);
  if (plans.some(({ plan }) => plan.task)) {
    const indices = new Set(data.grasps.map(({ index }) => index));
    const acts = { seek: (time_s: number) => player.seek(time_s), showGrasp: (index: number) => tip.select(index) };
    parts.push(new StagePanel(view, plans, { indices, reasons }, acts).element);
  }
  parts.push(new LayerPanel(view, available).element);
  if (data.grasps.length > 0) parts.push(new GraspPanel(view, data.grasps, plans, reasons).element);
  if (scene.trees.size > 0) parts.push(new TreePanel(view, scene, stage).element);
  if (kinematics.variables.length > 0) parts.push(new JointPanel(view, { scene, stage, kinematics, live }).element);
  shell.panel.append(...parts);
  const film = new Film(view, stage, player, data.name);
  const tip = new GraspTip(stage, scene, view, data.grasps, plans);
  const help = new Help();
  shell.viewport.append(tip.element);
  shell.element.append(help.element);

  // 4. Mouse and keyboard.
  const links = new LinkKeeper(view, () => flight.eye, player.canPlay);
  const actions = {
    look: (standard: (typeof STANDARD_VIEWS)[number]) => {
      flight.fly(scene.eye(standard));
      // A link stores the first standard view as "standard", so that it adapts to the window in which it is opened.
      view.set({ eye: standard === STANDARD_VIEWS[0] ? null : scene.eye(standard) });
    },
    stepGrasp: (by: number) => tip.step(by),
    copyLink: () => void links.copy().then((said) => shell.say(said)),
    toggleTheme: () => theme.toggle(),
    togglePanel: () => shell.togglePanel(),
    toggleHelp: () => help.toggle(),
    record: () => void film.record().then((said) => shell.say(said)),
  };
  shell.addTools(actions, theme, player.canPlay);
  listenToKeys(view, player, plans.length, available, actions);

  // 5. The first view. Unless the user has chosen a viewpoint, it follows the size of the window.
  const first = view.state.eye ?? scene.eye(STANDARD_VIEWS[0]);
  flight.fly(first, true);
  shell.onInsets(() => {
    if (view.state.eye === null) flight.fly(scene.eye(STANDARD_VIEWS[0]), true);
  });
  const describe = ({ time_s, plan }: ViewState): void => {
    const shown = plans[plan]?.plan;
    const name = shown ? `, plan ${shown.name} at ${progress(time_s, shown.is_timed)}` : "";
    const what = recording ? "Recording" : "The robot in scenario";
    stage.canvas.ariaLabel = `${what} ${data.name}${name}`;
  };
  view.on(["plan", "isPlaying"], describe);
  describe(view.state);
  // A motion plays at once, unless the link states a time or a posture, or the user prefers reduced motion.
  const isStill = asked.time_s !== undefined || asked.q !== undefined || STILL.matches;
  let isFirst = true;
  stage.onFrame(() => {
    if (isFirst) {
      requestAnimationFrame((now_ms) => {
        openInspection(stage, scene, view, live, now_ms);
        if (player.canPlay && !isStill) view.set({ isPlaying: true });
        if (data.feed !== undefined) {
          void followFeed(data.feed, view, scene.growing, () => {
            shell.tellSearch(scene.growing.count);
            stage.invalidate();
          });
        }
      });
    }
    isFirst = false;
    return false;
  });
}

function shownPlans(data: PageData, kinematics: Kinematics): ShownPlan[] {
  return data.plans.map((plan, index) => ({
    index,
    plan,
    trajectory: new Trajectory(plan, data.robot.start.length),
    clearance: plan.clearance ? new ClearanceCurve(plan.clearance) : null,
    carrying: plan.carries.length > 0 ? new Carrying(plan.carries, kinematics, data.nodes) : null,
    tree: plan.search_tree,
    colour: colours.ofPlan(index),
    reasons: new Map(plan.blocked.map(({ grasp, reason }) => [grasp, reason])),
  }));
}

/** The layers with visible content. */
function availableLayers(data: PageData, plans: ShownPlan[]): Set<Layer> {
  const hasPath = plans.some(({ trajectory }) => !trajectory.isEmpty);
  const layers: [Layer, boolean][] = [
    ["visual", true],
    ["collision", data.collision_shapes.length > 0],
    ["spheres", data.link_spheres.some((spheres) => spheres !== "")],
    ["grasps", data.grasps.length > 0],
    ["allGrasps", fewGrasps(data.grasps, data.plans).length < data.grasps.length],
    ["path", hasPath],
    ["ghosts", hasPath],
    ["closest", plans.some(({ clearance }) => clearance !== null)],
    ["tree", data.feed !== undefined || plans.some(({ tree }) => tree !== null)],
    ["others", plans.length > 1],
    ["floor", data.floor_area !== null],
    ["places", data.places.length > 0],
    ["glass", data.nodes.some(({ role }) => role === "obstacle")],
  ];
  return new Set(layers.flatMap(([layer, isThere]) => (isThere ? [layer] : [])));
}

/** Initial view from the link, limited to the available data; for a failed plan the reasons that blocked the grasps. */
function firstView(
  data: PageData,
  plans: ShownPlan[],
  recording: Recording | null,
  reasons: string[],
  asked: Partial<ViewState>,
): ViewState {
  const state = { ...INITIAL, ...asked };
  if (state.plan >= plans.length) state.plan = 0;
  const last_s = Math.max(recording?.duration_s ?? 0, ...plans.map(({ trajectory }) => trajectory.duration_s));
  state.time_s = Math.min(state.time_s, last_s);
  if (state.q?.length !== data.robot.start.length) state.q = null;
  const first = plans[state.plan];
  if (!asked.graspColour && first?.trajectory.isEmpty && reasons.length > 0) state.graspColour = "reason";
  if (state.graspColour === "reason" && reasons.length === 0) state.graspColour = "score";
  return state;
}
