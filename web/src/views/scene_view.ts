import { carriedBy } from "../motion/carrying.ts";
import { ClosestView } from "./closest_view.ts";
import { FloorView } from "./floor_view.ts";
import { type StandardView, framing } from "../framing.ts";
import { GhostView } from "./ghost_view.ts";
import { fewGrasps } from "../panels/grasp_choice.ts";
import { GraspView } from "./grasp_view.ts";
import { GrowingTree } from "../data/growing_tree.ts";
import { LightView } from "./light_view.ts";
import { MeshGeometries } from "./mesh_geometry.ts";
import { NodeView, onParent } from "./node_view.ts";
import type { PageData, Pose } from "../data/page_data.ts";
import { PathView } from "./path_view.ts";
import { PlaceView } from "./place_view.ts";
import { type Movers, type Posture, postureOf } from "../motion/posture.ts";
import { SceneBounds } from "../scene_bounds.ts";
import { hidingNodes } from "./see_through.ts";
import { SphereView } from "./sphere_view.ts";
import type { Stage } from "../stage.ts";
import type { Palette, ThemeName } from "../theme.ts";
import type { ShownPlan } from "../motion/trajectory.ts";
import { TreeView } from "./tree_view.ts";
import type { Eye, View, ViewState } from "../data/view_state.ts";

/** Opacity of collision shapes. */
const COLLISION_OPACITY = 0.5;

/** Everything that is drawn, kept up to date with the view. */
export class SceneView {
  readonly grasps: GraspView;
  readonly spheres: SphereView;
  readonly bounds: SceneBounds;
  /** Search trees of the plans that recorded them, by index of the plan. */
  readonly trees = new Map<number, TreeView>();
  /** Tree of a search under way. */
  readonly growing = new GrowingTree();
  posture: Posture;
  private readonly nodes: NodeView;
  private readonly collision: NodeView;
  private readonly floor: FloorView;
  private readonly places: PlaceView;
  private readonly light: LightView;
  private readonly ghosts: GhostView;
  private readonly paths: PathView[];
  private readonly closest = new ClosestView();
  private palette: Palette | null = null;
  private readonly stage: Stage;
  private readonly view: View;
  private readonly plans: ShownPlan[];
  private readonly movers: Movers;
  /** Names of all objects that any plan carries. */
  private readonly carried: ReadonlySet<string>;
  private readonly reasons: string[];
  private readonly few: number[];
  private readonly graspIndices: number[];

  constructor(
    data: PageData,
    movers: Movers,
    { stage, view, reasons }: { stage: Stage; view: View; reasons: string[] },
  ) {
    this.stage = stage;
    this.view = view;
    const { plans, kinematics } = movers;
    this.movers = movers;
    this.plans = plans;
    this.carried = carriedBy(plans);
    this.reasons = reasons;
    this.few = fewGrasps(data.grasps, data.plans);
    this.graspIndices = data.grasps.map(({ index }) => index);
    const geometries = new MeshGeometries(data);
    this.nodes = new NodeView(data.nodes, data.materials, geometries);
    this.collision = new NodeView(data.collision_shapes, data.materials, geometries, COLLISION_OPACITY);
    this.bounds = new SceneBounds(this.nodes, movers);
    const { middle, reach_m } = this.bounds;
    this.floor = new FloorView(data, middle, reach_m);
    this.places = new PlaceView(data, geometries);
    this.light = new LightView(middle, reach_m, stage.isSlow);
    this.spheres = new SphereView(data);
    this.grasps = new GraspView(data.grasps, plans.length);
    this.paths = plans.map((plan) => new PathView(plan, kinematics));
    this.ghosts = new GhostView(movers, geometries);
    for (const { index, tree } of plans) if (tree) this.trees.set(index, new TreeView(tree, stage));
    stage.scene.add(
      this.light.group,
      this.floor.group,
      this.places.group,
      this.nodes.group,
      this.collision.group,
      this.spheres.group,
      this.grasps.group,
      this.ghosts.ghosts,
      this.ghosts.others,
      this.closest.group,
      this.growing.lines,
      ...this.paths.map((path) => path.group),
      ...[...this.trees.values()].map((tree) => tree.group),
    );
    this.posture = postureOf(view.state, movers);
    view.on(["time_s", "plan", "q", "layers"], (state) => this.move(state));
    view.on(["plan", "ghosts", "layers"], (state) => this.showWay(state));
    view.on(["plan", "layers", "graspColour", "grasp", "reason"], (state) => this.showGrasps(state));
    view.on(["plan", "layers", "treeNodes"], (state) => this.showTree(state));
    view.on(["layers"], (state) => this.showLayers(state));
    stage.onBeforeDraw(() => {
      this.ghosts.sort(stage.camera.position);
      this.seeThrough();
    });
    for (const show of [this.showLayers, this.move, this.showWay, this.showGrasps, this.showTree]) {
      show.call(this, view.state);
    }
  }

  /** Called with the names of the obstacles shown as glass, whenever they change. */
  onSeenThrough: (names: string[]) => void = () => {};
  private seenThrough: string[] = [];

  setTheme(palette: Palette, name: ThemeName): void {
    this.palette = palette;
    this.light.setTheme(name === "dark");
    this.floor.setTheme(palette.gridLine, palette.ground, palette.groundOpacity, palette.shadowOpacity);
    this.nodes.setEdgeColour(palette.edge);
    this.collision.setEdgeColour(palette.edge);
    this.stage.setBackground(palette.page);
    this.showGrasps(this.view.state);
  }

  /** Tints the named bodies as in contact. */
  setTouching(names: ReadonlySet<string>): void {
    this.nodes.setTouching(names);
    this.collision.setTouching(names);
    this.stage.invalidate();
  }

  /** The frame of the target's first body. */
  get worldFromTarget(): Pose | null {
    return this.posture.worldFromNodes[this.nodes.nodes.findIndex(({ role }) => role === "target")] ?? null;
  }

  /** Current stage of the plan that moves the robot, if the plan states it. */
  get mode(): string {
    const { plan, time_s } = this.view.state;
    return this.plans[plan]?.carrying?.at(time_s).name ?? "";
  }

  /** Viewpoint of a standard view. */
  eye(view: StandardView): Eye {
    const { width, height, wholeHeight } = this.stage.free;
    return framing(view, this.bounds.focus, width / wholeHeight, height / wholeHeight);
  }

  private showLayers({ layers }: ViewState): void {
    this.nodes.group.visible = layers.visual;
    this.collision.group.visible = layers.collision;
    this.spheres.group.visible = layers.spheres;
    if (this.floor.area) this.floor.area.visible = layers.floor;
    this.places.group.visible = layers.places;
    this.stage.invalidateShadows();
  }

  private move(state: ViewState): void {
    this.posture = postureOf(state, this.movers);
    const { worldFromLinks, worldFromNodes, moved } = this.posture;
    this.nodes.pose(worldFromNodes);
    if (state.layers.collision) {
      this.collision.pose(this.collision.nodes.map((shape) => onParent(shape, worldFromNodes, moved)));
    }
    this.spheres.pose(worldFromLinks);
    const others = this.plans.filter(({ index }) => state.layers.others && index !== state.plan);
    this.ghosts.showOthers(others, state.time_s);
    this.ghosts.makeWay(this.posture.q);
    this.paths.forEach((path, index) => {
      path.group.visible = state.layers.path && (index === state.plan || state.layers.others);
      path.show(state.time_s, index === state.plan);
    });
    const clearance = this.plans[state.plan]?.clearance;
    this.closest.show(state.layers.closest && !state.q && clearance ? clearance.at(state.time_s) : null);
    this.stage.invalidateShadows();
  }

  private showWay({ plan, layers, ghosts }: ViewState): void {
    this.ghosts.showWay(this.plans[plan] ?? null, layers.ghosts ? ghosts : 0);
    this.ghosts.makeWay(this.posture.q);
    this.stage.invalidate();
  }

  private showGrasps({ plan, layers, graspColour, grasp, reason }: ViewState): void {
    const shown = this.plans[plan] ?? null;
    this.grasps.group.visible = layers.grasps;
    const isFew = new Set(this.few);
    const isShown = (index: number, place: number): boolean =>
      layers.allGrasps || isFew.has(place) || (reason !== null && shown?.reasons.get(index) === reason);
    this.grasps.show(this.graspIndices.flatMap((index, place) => (isShown(index, place) ? [place] : [])));
    this.grasps.paint(graspColour, shown, this.reasons, reason, this.palette?.page ?? "#ffffff");
    const ends = this.plans.filter(({ index }) => layers.others || index === plan);
    // The selected plan comes last, and is thus drawn over the others.
    this.grasps.emphasise(
      ends.sort((a, b) => Number(a.index === plan) - Number(b.index === plan)),
      grasp,
      this.palette?.pointed ?? "#000000",
    );
    this.stage.invalidate();
  }

  private showTree({ plan, layers, treeNodes }: ViewState): void {
    this.growing.show(layers.tree);
    for (const [index, tree] of this.trees) {
      tree.group.visible = layers.tree && index === plan;
      tree.show(treeNodes ?? tree.count);
    }
    this.stage.invalidate();
  }

  /** Shows obstacles that block the view as glass. */
  private seeThrough(): void {
    const { position } = this.stage.camera;
    const { layers } = this.view.state;
    const hiding = layers.glass
      ? hidingNodes(this.nodes, [position.x, position.y, position.z], this.bounds.wanted, this.carried)
      : new Set<number>();
    this.nodes.setGlass(hiding);
    const names = [...new Set([...hiding].map((index) => this.nodes.nodes[index].name))].sort();
    if (names.join() !== this.seenThrough.join()) {
      this.seenThrough = names;
      this.onSeenThrough(names);
    }
  }
}
