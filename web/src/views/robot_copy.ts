import {
  BufferAttribute,
  BufferGeometry,
  Color,
  DataTexture,
  FloatType,
  Group,
  Matrix4,
  Mesh,
  NearestFilter,
  RGBAFormat,
  ShaderMaterial,
} from "three";
import type { MeshGeometries } from "./mesh_geometry.ts";
import { setMatrix } from "./mesh_geometry.ts";
import type { Node, Pose } from "../data/page_data.ts";

/** Merges nodes into one geometry in which each vertex stores the index of its node: a copy of the robot with carried
 * objects then needs only two draw calls. */
export function robotGeometry(nodes: Node[], geometries: MeshGeometries): BufferGeometry {
  const positions: number[] = [];
  const normals: number[] = [];
  const owners: number[] = [];
  const triangles: number[] = [];
  nodes.forEach((node, link) => {
    if (node.mesh === null) return;
    for (const { geometry } of geometries.of(node.mesh)) {
      const first = owners.length;
      const [position, normal] = [geometry.getAttribute("position"), geometry.getAttribute("normal")];
      for (let i = 0; i < position.count; i += 1) {
        positions.push(position.getX(i), position.getY(i), position.getZ(i));
        normals.push(normal.getX(i), normal.getY(i), normal.getZ(i));
        owners.push(link);
      }
      for (const corner of geometry.index?.array ?? []) triangles.push(first + corner);
    }
  });
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(positions), 3));
  geometry.setAttribute("normal", new BufferAttribute(new Float32Array(normals), 3));
  geometry.setAttribute("link", new BufferAttribute(new Float32Array(owners), 1));
  geometry.setIndex(new BufferAttribute(new Uint32Array(triangles), 1));
  return geometry;
}

export interface CopyLook {
  colour: string;
  /** Opacity as seen from the front, and its increase towards grazing views. */
  opacity: number;
  rim: number;
}

/** A copy of the robot in coloured glass. Its depth is drawn first, so that only its outer surface is visible. */
export class RobotCopy {
  readonly group = new Group();
  private readonly rows: Float32Array;
  private readonly poses: DataTexture;
  private readonly parts: Mesh[];
  private readonly matrix = new Matrix4();
  private readonly opacity: { value: number };

  /** `nodes`: number of nodes in the geometry. */
  constructor(geometry: BufferGeometry, nodes: number, look: CopyLook) {
    this.rows = new Float32Array(16 * nodes);
    this.poses = new DataTexture(this.rows, 4, nodes, RGBAFormat, FloatType);
    this.poses.minFilter = this.poses.magFilter = NearestFilter;
    this.opacity = { value: look.opacity };
    const uniforms = {
      poses: { value: this.poses },
      colour: { value: new Color(look.colour) },
      opacity: this.opacity,
      rim: { value: look.rim },
    };
    const both = { uniforms, vertexShader: VERTEX, fragmentShader: FRAGMENT, transparent: true };
    const depth = new ShaderMaterial({ ...both, colorWrite: false });
    const skin = new ShaderMaterial({ ...both, depthWrite: false });
    this.parts = [depth, skin].map((material) => {
      const mesh = new Mesh(geometry, material);
      mesh.frustumCulled = false;
      this.group.add(mesh);
      return mesh;
    });
    this.setOrder(0);
  }

  /** Sets the poses of all nodes; a node without a pose is hidden. */
  pose(worldFromNodes: (Pose | null)[]): void {
    worldFromNodes.forEach((pose, node) => {
      const matrix = pose ? setMatrix(this.matrix, pose) : this.matrix.makeScale(0, 0, 0);
      matrix.toArray(this.rows, 16 * node);
    });
    this.poses.needsUpdate = true;
  }

  setOpacity(opacity: number): void {
    this.opacity.value = opacity;
  }

  /** Drawing order of several copies: the farthest comes first, a higher `order` later. */
  setOrder(order: number): void {
    this.parts.forEach((part, index) => (part.renderOrder = 2 + 0.01 * order + 0.001 * index));
  }
}

const VERTEX = `
  attribute float link;
  uniform highp sampler2D poses;
  varying vec3 facing;
  varying vec3 seen;
  void main() {
    int row = int(link + 0.5);
    mat4 world = mat4(
      texelFetch(poses, ivec2(0, row), 0), texelFetch(poses, ivec2(1, row), 0),
      texelFetch(poses, ivec2(2, row), 0), texelFetch(poses, ivec2(3, row), 0)
    );
    vec4 place = viewMatrix * world * vec4(position, 1.0);
    facing = mat3(viewMatrix) * mat3(world) * normal;
    seen = place.xyz;
    gl_Position = projectionMatrix * place;
  }
`;

const FRAGMENT = `
  uniform vec3 colour;
  uniform float opacity;
  uniform float rim;
  varying vec3 facing;
  varying vec3 seen;
  void main() {
    vec3 normal = normalize(facing);
    float frontal = abs(dot(normal, normalize(seen)));
    float side = pow(1.0 - frontal, 2.0);
    float light = 0.72 + 0.28 * normal.y;
    float alpha = min(opacity * (1.0 - 0.4 * rim + 1.8 * rim * side), 0.95);
    gl_FragColor = vec4(mix(colour, vec3(1.0), 0.35 * frontal) * light, alpha);
    #include <colorspace_fragment>
  }
`;
