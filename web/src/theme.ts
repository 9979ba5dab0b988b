export type ThemeName = "light" | "dark";

/** Colours of the scene; those of panels are in the style sheet. */
export interface Palette {
  page: string;
  /** Colour of the grasp under the pointer, or selected in a list. */
  pointed: string;
  gridLine: number;
  ground: number;
  groundOpacity: number;
  shadowOpacity: number;
  edge: number;
}

const PALETTES: Record<ThemeName, Palette> = {
  light: {
    page: "#eef1f4",
    pointed: "#0d1117",
    gridLine: 0x9aa7b5,
    ground: 0xffffff,
    groundOpacity: 0.55,
    shadowOpacity: 0.22,
    edge: 0x3c4a5a,
  },
  dark: {
    page: "#15181d",
    pointed: "#ffffff",
    gridLine: 0x5d6b7c,
    ground: 0x22272e,
    groundOpacity: 0.6,
    shadowOpacity: 0.45,
    edge: 0x9db2cc,
  },
};

const KEY = "cranny-theme";

/** Light or dark: the system's setting unless the user chooses. */
export class Theme {
  private chosen: ThemeName | null;
  private readonly system = matchMedia("(prefers-color-scheme: dark)");
  private readonly listeners: ((palette: Palette, name: ThemeName) => void)[] = [];

  constructor() {
    this.chosen = remembered();
    this.system.addEventListener("change", () => this.apply());
    this.apply();
  }

  get name(): ThemeName {
    return this.chosen ?? (this.system.matches ? "dark" : "light");
  }

  get palette(): Palette {
    return PALETTES[this.name];
  }

  /** Calls `listener` now and at each change. */
  on(listener: (palette: Palette, name: ThemeName) => void): void {
    this.listeners.push(listener);
    listener(this.palette, this.name);
  }

  toggle(): void {
    this.chosen = this.name === "dark" ? "light" : "dark";
    try {
      localStorage.setItem(KEY, this.chosen);
    } catch {
      // A page opened from disk may have no storage; the choice then lasts until it is closed.
    }
    this.apply();
  }

  private apply(): void {
    document.documentElement.dataset["theme"] = this.name;
    for (const listener of this.listeners) listener(this.palette, this.name);
  }
}

function remembered(): ThemeName | null {
  try {
    const name = localStorage.getItem(KEY);
    return name === "light" || name === "dark" ? name : null;
  } catch {
    return null;
  }
}
