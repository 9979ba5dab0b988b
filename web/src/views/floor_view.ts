import { CircleGeometry, Color, Group, Mesh, PlaneGeometry, ShaderMaterial, ShadowMaterial } from "three";
import { setMatrix } from "./mesh_geometry.ts";
import type { PageData, Point } from "../data/page_data.ts";
import { compose, inverse, transformed } from "../motion/pose.ts";
import { rectangle } from "./rectangle.ts";

/** The floor: a grid that fades into the page, shadows, and the permitted area of the base. */
export class FloorView {
  readonly group = new Group();
  readonly area: Group | null;
  private readonly grid: ShaderMaterial;
  private readonly shadow: ShadowMaterial;

  /** `middle` and `reach_m`: centre and radius of all visible bodies. */
  constructor(data: PageData, middle: Point, reach_m: number) {
    this.grid = new ShaderMaterial({
      transparent: true,
      depthWrite: false,
      uniforms: {
        line: { value: new Color() },
        ground: { value: new Color() },
        groundOpacity: { value: 0.5 },
        reach: { value: reach_m },
      },
      vertexShader: GRID_VERTEX,
      fragmentShader: GRID_FRAGMENT,
    });
    this.shadow = new ShadowMaterial({ transparent: true, depthWrite: false, opacity: 0.2 });
    const size = reach_m * 5;
    const grid = new Mesh(new CircleGeometry(size / 2, 64), this.grid);
    const shadow = new Mesh(new PlaneGeometry(size, size), this.shadow);
    grid.renderOrder = -3;
    shadow.renderOrder = -2;
    shadow.receiveShadow = true;
    const plane = new Group();
    plane.add(grid, shadow);
    if (data.world_from_floor) {
      const pose = data.world_from_floor;
      // Centred near the visible bodies, on a crossing of grid lines.
      const [x, y] = transformed(inverse(pose), middle);
      const shifted = compose(pose, [Math.round(x), Math.round(y), 0, 0, 0, 0, 1]);
      setMatrix(plane.matrix, shifted).decompose(plane.position, plane.quaternion, plane.scale);
      this.group.add(plane);
    }
    this.area = data.floor_area ? floorArea(data.floor_area, data.world_from_floor?.[2] ?? 0) : null;
    if (this.area) this.group.add(this.area);
  }

  setTheme(line: number, ground: number, groundOpacity: number, shadowOpacity: number): void {
    this.grid.uniforms["line"].value.setHex(line);
    this.grid.uniforms["ground"].value.setHex(ground);
    this.grid.uniforms["groundOpacity"].value = groundOpacity;
    this.shadow.opacity = shadowOpacity;
  }
}

const AREA = 0x2f7de1;

function floorArea({ low, high }: NonNullable<PageData["floor_area"]>, z: number): Group {
  const area = rectangle(high[0] - low[0], high[1] - low[1], AREA);
  area.position.set((low[0] + high[0]) / 2, (low[1] + high[1]) / 2, z);
  return area;
}

const GRID_VERTEX = `
  varying vec2 place;
  void main() {
    place = position.xy;
    gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  }
`;

// Lines every quarter metre, every fourth stronger; one point wide at any distance, fainter where they are dense.
const GRID_FRAGMENT = `
  uniform vec3 line;
  uniform vec3 ground;
  uniform float groundOpacity;
  uniform float reach;
  varying vec2 place;
  float lines(float spacing) {
    vec2 at = place / spacing;
    vec2 width = fwidth(at);
    vec2 away = abs(fract(at - 0.5) - 0.5) / max(width, vec2(1e-6));
    float density = max(width.x, width.y);
    return (1.0 - min(min(away.x, away.y), 1.0)) * (1.0 - smoothstep(0.15, 0.6, density));
  }
  void main() {
    float fade = 1.0 - smoothstep(0.7 * reach, 2.3 * reach, length(place));
    float on = max(0.28 * lines(0.25), 0.62 * lines(1.0)) * fade;
    float floorShare = groundOpacity * fade;
    float alpha = on + floorShare * (1.0 - on);
    gl_FragColor = vec4(mix(ground, line, on / max(alpha, 1e-4)), alpha);
    #include <colorspace_fragment>
  }
`;
