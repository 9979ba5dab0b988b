import { Color, PerspectiveCamera, Scene, WebGLRenderer } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { HEIGHT_RAD } from "./framing.ts";
import type { Point } from "./data/page_data.ts";

/** Margins of the canvas covered by panels, in points. */
export interface Insets {
  left: number;
  top: number;
  right: number;
  bottom: number;
}

/** Projects a point to the screen. */
export type Lens = (point: Point) => { x: number; y: number; depth: number };

/** Advances an animation by the time since the last frame; returns true if it needs another frame. */
export type Step = (elapsed_s: number) => boolean;

/** The canvas, its camera and its frames. A frame is drawn only after a change, so that an idle page costs nothing. */
export class Stage {
  readonly scene = new Scene();
  readonly camera: PerspectiveCamera;
  readonly controls: OrbitControls;
  readonly renderer: WebGLRenderer;
  readonly canvas: HTMLCanvasElement;
  /** Script time of the last frame, until its commands are with the graphics card. */
  frameScript_ms = 0;
  frames = 0;
  /** Whether the machine renders without a graphics card. */
  readonly isSlow: boolean;
  private insets: Insets = { left: 0, top: 0, right: 0, bottom: 0 };
  private readonly steps: Step[] = [];
  private readonly beforeDraw: (() => void)[] = [];
  private isDue = false;
  private isScheduled = false;
  private last_ms: number | null = null;

  constructor(host: HTMLElement) {
    this.renderer = new WebGLRenderer({ antialias: true, alpha: true, powerPreference: "high-performance" });
    this.renderer.info.autoReset = false;
    this.renderer.setClearAlpha(0);
    this.isSlow = drawsInSoftware(this.renderer);
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.autoUpdate = false;
    this.renderer.shadowMap.needsUpdate = true;
    this.canvas = this.renderer.domElement;
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute("role", "img");
    host.append(this.canvas);
    this.camera = new PerspectiveCamera((HEIGHT_RAD * 180) / Math.PI, 1, 0.05, 60);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.enableDamping = true;
    this.controls.dampingFactor = 0.18;
    this.controls.zoomToCursor = true;
    this.controls.minDistance = 0.15;
    this.controls.maxDistance = 40;
    this.controls.addEventListener("change", () => this.invalidate());
    this.canvas.addEventListener("webglcontextrestored", () => {
      this.renderer.shadowMap.needsUpdate = true;
      this.invalidate();
    });
    new ResizeObserver(() => this.fit()).observe(host);
    this.fit();
  }

  /** Registers a callback for every frame. */
  onFrame(step: Step): void {
    this.steps.push(step);
  }

  onBeforeDraw(callback: () => void): void {
    this.beforeDraw.push(callback);
  }

  /** Requests a frame. */
  invalidate(): void {
    this.isDue = true;
    this.schedule();
  }

  /** Requests a frame after objects that cast shadows have moved. */
  invalidateShadows(): void {
    this.renderer.shadowMap.needsUpdate = true;
    this.invalidate();
  }

  /** Whether no frame is due. */
  get isIdle(): boolean {
    return !this.isScheduled;
  }

  setBackground(colour: string): void {
    this.renderer.setClearColor(new Color(colour), this.renderer.getClearAlpha());
    this.invalidate();
  }

  /** Whether the canvas draws its background or is transparent. */
  setOpaque(isOpaque: boolean): void {
    this.renderer.setClearAlpha(isOpaque ? 1 : 0);
    this.invalidate();
  }

  /** Sets the margins covered by panels, and centres the view in the free area. */
  setInsets(insets: Insets): void {
    this.insets = insets;
    this.fit();
  }

  /** Width and height of the area free of panels, and the whole height, in points. */
  get free(): { width: number; height: number; wholeHeight: number } {
    const { clientWidth, clientHeight } = this.canvas;
    const { left, right, top, bottom } = this.insets;
    return {
      width: Math.max(clientWidth - left - right, 1),
      height: Math.max(clientHeight - top - bottom, 1),
      wholeHeight: Math.max(clientHeight, 1),
    };
  }

  /** Edges of the area free of panels, in points from the upper left corner of the canvas. */
  get freeEdges(): { left: number; top: number; right: number; bottom: number } {
    const { left, right, top, bottom } = this.insets;
    return { left, top, right: this.canvas.clientWidth - right, bottom: this.canvas.clientHeight - bottom };
  }

  /** Current projection, in points from the upper left corner of the canvas; depth is below 1 for visible points. */
  get lens(): Lens {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const { projectionMatrix, matrixWorldInverse } = this.camera;
    const m = projectionMatrix.clone().multiply(matrixWorldInverse).elements;
    return ([x, y, z]) => {
      const w = m[3] * x + m[7] * y + m[11] * z + m[15];
      // Points behind the camera are invisible.
      if (w <= 0) return { x: 0, y: 0, depth: Infinity };
      const across = (m[0] * x + m[4] * y + m[8] * z + m[12]) / w;
      const upwards = (m[1] * x + m[5] * y + m[9] * z + m[13]) / w;
      const depth = (m[2] * x + m[6] * y + m[10] * z + m[14]) / w;
      return { x: (0.5 + 0.5 * across) * width, y: (0.5 - 0.5 * upwards) * height, depth };
    };
  }

  private fit(): void {
    const host = this.canvas.parentElement;
    const width = Math.max(host?.clientWidth ?? 1, 1);
    const height = Math.max(host?.clientHeight ?? 1, 1);
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, MOST_PIXELS_PER_POINT));
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    const { left, top, right, bottom } = this.insets;
    this.camera.setViewOffset(width, height, (right - left) / 2, (bottom - top) / 2, width, height);
    this.camera.updateProjectionMatrix();
    this.invalidate();
  }

  private schedule(): void {
    if (this.isScheduled) return;
    this.isScheduled = true;
    requestAnimationFrame((now_ms) => this.frame(now_ms));
  }

  private frame(now_ms: number): void {
    const begin_ms = performance.now();
    const elapsed_s = this.last_ms === null ? 0 : Math.min((now_ms - this.last_ms) / 1000, LONGEST_S);
    this.isScheduled = false;
    this.isDue = false;
    let goesOn = false;
    for (const step of this.steps) goesOn = step(elapsed_s) || goesOn;
    // Sends a "change" event if the camera is still moving.
    this.controls.update();
    this.renderer.info.reset();
    for (const callback of this.beforeDraw) callback();
    this.renderer.render(this.scene, this.camera);
    this.frames += 1;
    this.frameScript_ms = performance.now() - begin_ms;
    this.last_ms = now_ms;
    if (goesOn || this.isDue) this.schedule();
    else this.last_ms = null;
  }
}

/** A page that was in the background continues where it stopped. */
const LONGEST_S = 1;

/** Higher resolutions cost time without a visible gain. */
const MOST_PIXELS_PER_POINT = 2;

/** Names of software renderers: Chromium's, Mesa's, Windows'. */
const SOFTWARE = /swiftshader|llvmpipe|softpipe|software|basic render/i;

function drawsInSoftware(renderer: WebGLRenderer): boolean {
  const context = renderer.getContext();
  const names = context.getExtension("WEBGL_debug_renderer_info");
  return SOFTWARE.test(String(context.getParameter(names ? names.UNMASKED_RENDERER_WEBGL : context.RENDERER)));
}
