import { DirectionalLight, Group, HemisphereLight } from "three";

/** Direction of the sun in degrees: from behind the robot on the right, as in Cranny's pictures. */
const SUN_TURN_DEG = -152;
const SUN_RISE_DEG = 52;

/** Texels per side of the shadow map; fewer without a graphics card. */
const SHADOW_SIDE = 2048;
const SLOW_SHADOW_SIDE = 1024;

/** A sun that casts shadows, a sky, and a faint light from the other side. */
export class LightView {
  readonly group = new Group();
  private readonly sun = new DirectionalLight(0xfff6ea, 1);
  private readonly fill = new DirectionalLight(0xdfe9ff, 1);
  private readonly sky = new HemisphereLight(0xffffff, 0xbfc0c4, 1);

  constructor(middle: [number, number, number], reach_m: number, isSlow: boolean) {
    const side = isSlow ? SLOW_SHADOW_SIDE : SHADOW_SIDE;
    this.group.add(this.sky, this.sun, this.sun.target, this.fill, this.fill.target);
    const radians = (degrees: number): number => (degrees * Math.PI) / 180;
    const [turn, rise] = [radians(SUN_TURN_DEG), radians(SUN_RISE_DEG)];
    const away = 3 * reach_m;
    this.sun.target.position.set(...middle);
    this.sun.position
      .set(Math.cos(rise) * Math.cos(turn), Math.cos(rise) * Math.sin(turn), Math.sin(rise))
      .multiplyScalar(away)
      .add(this.sun.target.position);
    this.fill.target.position.set(...middle);
    this.fill.position.set(0.5, -0.8, 0.35).multiplyScalar(away).add(this.fill.target.position);
    this.sun.castShadow = true;
    const { shadow } = this.sun;
    shadow.mapSize.set(side, side);
    shadow.camera.left = shadow.camera.bottom = -reach_m;
    shadow.camera.right = shadow.camera.top = reach_m;
    shadow.camera.near = away - 1.5 * reach_m;
    shadow.camera.far = away + 1.5 * reach_m;
    // An offset of three texels prevents a surface from shadowing itself.
    shadow.normalBias = (6 * reach_m) / side;
    shadow.bias = -0.0008;
    shadow.radius = 3;
  }

  setTheme(isDark: boolean): void {
    this.sky.intensity = isDark ? 0.85 : 1.45;
    this.sky.color.setHex(isDark ? 0xcfd8e8 : 0xffffff);
    this.sky.groundColor.setHex(isDark ? 0x4a4e58 : 0xb9bcc4);
    this.sun.intensity = isDark ? 2.2 : 2.2;
    this.fill.intensity = isDark ? 0.5 : 0.45;
  }
}
