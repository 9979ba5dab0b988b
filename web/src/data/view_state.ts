/** Layers that can be shown or hidden. */
export type Layer =
  | "visual"
  | "collision"
  | "spheres"
  | "grasps"
  | "allGrasps"
  | "path"
  | "ghosts"
  | "closest"
  | "tree"
  | "others"
  | "glass"
  | "floor"
  | "places";

/** Quantity that the colour of a grasp shows. */
export type GraspColour = "score" | "ik" | "reason";

export interface Eye {
  position: [number, number, number];
  /** Point at the centre of the view. */
  target: [number, number, number];
}

/** All choices of the user, which a link to the view contains. */
export interface ViewState {
  /** Index of the plan that moves the robot; the others are shown next to it. */
  plan: number;
  time_s: number;
  isPlaying: boolean;
  /** Whether a motion restarts after its end. */
  isLooping: boolean;
  /** Seconds of the path per second of the clock. */
  speed: number;
  /** The robot as posed by hand; null: as on the path. */
  q: number[] | null;
  layers: Record<Layer, boolean>;
  ghosts: number;
  /** Number of shown nodes of the search tree; null: all. */
  treeNodes: number | null;
  isTreeGrowing: boolean;
  graspColour: GraspColour;
  /** The grasp under the pointer. */
  grasp: number | null;
  /** The reason under the pointer in the list. */
  reason: string | null;
  /** Null: the standard view. */
  eye: Eye | null;
}

export const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4];

export const MOST_GHOSTS = 12;

export const INITIAL: ViewState = {
  plan: 0,
  time_s: 0,
  isPlaying: false,
  isLooping: false,
  speed: 1,
  q: null,
  layers: {
    visual: true,
    collision: false,
    spheres: false,
    grasps: true,
    allGrasps: false,
    path: true,
    ghosts: false,
    closest: true,
    tree: false,
    others: true,
    glass: true,
    floor: false,
    places: true,
  },
  ghosts: 5,
  treeNodes: null,
  isTreeGrowing: false,
  graspColour: "score",
  grasp: null,
  reason: null,
  eye: null,
};

type Changed = ReadonlySet<keyof ViewState>;

/** The only store of the view's state; it notifies its listeners of changes. */
export class View {
  private current: ViewState;
  private readonly listeners: ((state: ViewState, changed: Changed) => void)[] = [];

  constructor(state: ViewState = INITIAL) {
    this.current = state;
  }

  get state(): Readonly<ViewState> {
    return this.current;
  }

  /** Calls `listener` at each change of one of the keys. */
  on(keys: (keyof ViewState)[], listener: (state: ViewState) => void): void {
    this.listeners.push((state, changed) => {
      if (keys.some((key) => changed.has(key))) listener(state);
    });
  }

  set(part: Partial<ViewState>): void {
    const keys = Object.keys(part) as (keyof ViewState)[];
    const changed = new Set(keys.filter((key) => !Object.is(part[key], this.current[key])));
    if (changed.size === 0) return;
    this.current = { ...this.current, ...part };
    for (const listener of this.listeners) listener(this.current, changed);
  }

  setLayer(layer: Layer, isShown: boolean): void {
    if (this.current.layers[layer] === isShown) return;
    this.set({ layers: { ...this.current.layers, [layer]: isShown } });
  }
}
