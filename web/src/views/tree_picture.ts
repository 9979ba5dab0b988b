import {
  DepthTexture,
  type LineSegments,
  Matrix4,
  Mesh,
  NearestFilter,
  type PerspectiveCamera,
  PlaneGeometry,
  Scene,
  ShaderMaterial,
  Vector2,
  type WebGLRenderer,
  WebGLRenderTarget,
} from "three";

/** A tree rendered once, with depth, and shown again as long as the camera rests; robots move in front of it and behind
 * it. For machines without a graphics card, on which 10⁵ lines cost more than everything else. */
export class TreePicture {
  readonly quad: Mesh<PlaneGeometry, ShaderMaterial>;
  private readonly target = new WebGLRenderTarget(1, 1, { minFilter: NearestFilter, magFilter: NearestFilter });
  private readonly scene = new Scene();
  private readonly eye = new Matrix4();
  private readonly size = new Vector2();
  private drawn = 0;
  private hasEye = false;

  constructor(opacity: number) {
    this.target.depthTexture = new DepthTexture(1, 1);
    const uniforms = {
      lines: { value: this.target.texture },
      depth: { value: this.target.depthTexture },
      opacity: { value: opacity },
    };
    const look = { uniforms, vertexShader: VERTEX, fragmentShader: FRAGMENT, transparent: true, depthWrite: false };
    this.quad = new Mesh(new PlaneGeometry(2, 2), new ShaderMaterial(look));
    this.quad.frustumCulled = false;
  }

  /** Whether the camera is where it was at the last call. */
  isResting(camera: PerspectiveCamera, renderer: WebGLRenderer): boolean {
    const eye = camera.projectionMatrix.clone().multiply(camera.matrixWorldInverse);
    const size = renderer.getDrawingBufferSize(new Vector2());
    const isSame = this.hasEye && isNear(eye, this.eye) && size.equals(this.size);
    if (!isSame) {
      this.eye.copy(eye);
      this.size.copy(size);
      this.hasEye = true;
      this.drawn = 0;
    }
    return isSame;
  }

  /** Draws the first `nodes` lines; for a growing tree, only the new ones. */
  draw(lines: LineSegments, nodes: number, camera: PerspectiveCamera, renderer: WebGLRenderer): void {
    if (nodes === this.drawn) return;
    const isAnew = this.drawn === 0 || nodes < this.drawn;
    const first = isAnew ? 0 : this.drawn;
    this.target.setSize(this.size.x, this.size.y);
    const parent = lines.parent;
    const wasVisible = lines.visible;
    lines.visible = true;
    this.scene.add(lines);
    lines.geometry.setDrawRange(2 * first, 2 * (nodes - first));
    const { autoClear, shadowMap } = renderer;
    const shadowsAreDue = shadowMap.needsUpdate;
    shadowMap.needsUpdate = false;
    renderer.autoClear = false;
    renderer.setRenderTarget(this.target);
    if (isAnew) renderer.clear();
    renderer.render(this.scene, camera);
    renderer.setRenderTarget(null);
    renderer.autoClear = autoClear;
    shadowMap.needsUpdate = shadowsAreDue;
    lines.geometry.setDrawRange(0, 2 * nodes);
    lines.visible = wasVisible;
    parent?.add(lines);
    this.drawn = nodes;
  }
}

/** Orbiting a point changes the camera's matrix in its last digits even at rest. */
const SHAKE = 1e-7;

function isNear(a: Matrix4, b: Matrix4): boolean {
  return a.elements.every((value, i) => Math.abs(value - b.elements[i]) <= SHAKE);
}

const VERTEX = `
  varying vec2 place;
  void main() {
    place = uv;
    gl_Position = vec4(position.xy, 0.0, 1.0);
  }
`;

const FRAGMENT = `
  uniform sampler2D lines;
  uniform sampler2D depth;
  uniform float opacity;
  varying vec2 place;
  void main() {
    vec4 line = texture2D(lines, place);
    if (line.a == 0.0) discard;
    gl_FragDepth = texture2D(depth, place).r;
    gl_FragColor = vec4(line.rgb, opacity);
    #include <colorspace_fragment>
  }
`;
