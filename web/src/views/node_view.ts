import {
  type BufferGeometry,
  DoubleSide,
  EdgesGeometry,
  FrontSide,
  Group,
  LineBasicMaterial,
  LineSegments,
  Matrix4,
  Mesh,
  MeshStandardMaterial,
} from "three";
import type { Moved } from "../motion/carrying.ts";
import type { MeshGeometries } from "./mesh_geometry.ts";
import { setMatrix } from "./mesh_geometry.ts";
import type { Material, Node, Pose } from "../data/page_data.ts";
import { compose } from "../motion/pose.ts";

/** Appearance of a node in addition to its material. */
interface Look {
  isLink: boolean;
  isTouching: boolean;
  isGlass: boolean;
}

/** Tint of bodies in contact; large bodies such as walls need less of it. */
const CONTACT = 0xe0342b;
const LINK_TINT = 0.8;
const BODY_TINT = 0.4;

/** Opacity of obstacles that hide points of interest. */
const GLASS_OPACITY = 0.32;

/** Edges flatter than this, in degrees, get no line. */
const EDGE_DEG = 35;

/** Poses of all nodes, of which the links come first; other bodies as `moved` by the hand, or as in the scenario. */
export function worldFromNodes(nodes: Node[], worldFromLinks: Pose[], moved: Moved): Pose[] {
  const poses: Pose[] = [];
  nodes.forEach((node, index) => poses.push(worldFromLinks[index] ?? onParent(node, poses, moved)));
  return poses;
}

/** Pose of a node attached to one of `parents` or to none, which may have `moved`. */
export function onParent(node: Node, parents: Pose[], moved: Moved): Pose {
  if (node.parent !== null) return compose(parents[node.parent], node.parent_from_node);
  const motion = moved.get(node.name);
  return motion ? compose(motion, node.parent_from_node) : node.parent_from_node;
}

/** Robot and bodies as meshes: visible ones, or collision shapes. */
export class NodeView {
  readonly group = new Group();
  readonly nodes: Node[];
  /** Poses of all nodes as last shown. */
  worldFromNodes: Pose[] = [];
  private readonly meshes: Mesh[][];
  private readonly edges: (LineSegments | null)[];
  private readonly looks: Look[];
  private readonly materials: Material[];
  private readonly known = new Map<string, MeshStandardMaterial>();
  private readonly edgeMaterial = new LineBasicMaterial({ transparent: true, opacity: 0.35 });
  private readonly opacity: number;

  /** `opacity`: factor for the materials' own; only at 1 are shadows drawn. */
  constructor(nodes: Node[], materials: Material[], geometries: MeshGeometries, opacity = 1) {
    this.nodes = nodes;
    this.materials = materials;
    this.opacity = opacity;
    this.looks = nodes.map(({ role }) => ({ isLink: role === "link", isTouching: false, isGlass: false }));
    this.meshes = nodes.map((node, index) => {
      if (node.mesh === null) return [];
      return geometries.of(node.mesh).map(({ geometry, material }) => {
        const mesh = new Mesh(geometry, this.material(material, geometry, this.looks[index]));
        mesh.userData["material"] = material;
        mesh.matrixAutoUpdate = false;
        mesh.castShadow = opacity === 1;
        mesh.receiveShadow = opacity === 1;
        this.group.add(mesh);
        return mesh;
      });
    });
    this.edges = nodes.map((node, index) => {
      if (node.role !== "obstacle") return null;
      const geometry = this.meshes[index][0]?.geometry;
      return geometry ? this.edge(geometry) : null;
    });
  }

  /** Sets the poses of all nodes; `worldFromNodes` is by node. */
  pose(worldFromNodes: Pose[]): void {
    this.worldFromNodes = worldFromNodes;
    worldFromNodes.forEach((world, index) => {
      for (const part of [...this.meshes[index], this.edges[index]]) {
        if (!part) continue;
        setMatrix(part.matrix, world);
        part.matrixWorldNeedsUpdate = true;
      }
    });
  }

  /** Tints the named bodies as in contact. */
  setTouching(names: ReadonlySet<string>): void {
    this.change((node) => ({ isTouching: names.has(node.name) }));
  }

  /** Shows nodes as glass, by index. */
  setGlass(hiding: ReadonlySet<number>): void {
    this.change((_, index) => ({ isGlass: hiding.has(index) }));
  }

  setEdgeColour(colour: number): void {
    this.edgeMaterial.color.setHex(colour);
  }

  /** Bounding box of a node's mesh, in its own frame. */
  box(index: number): { low: [number, number, number]; high: [number, number, number] } | null {
    const low: [number, number, number] = [Infinity, Infinity, Infinity];
    const high: [number, number, number] = [-Infinity, -Infinity, -Infinity];
    for (const mesh of this.meshes[index]) {
      const box = mesh.geometry.boundingBox;
      if (!box) continue;
      box.min.toArray().forEach((value, i) => (low[i] = Math.min(low[i], value)));
      box.max.toArray().forEach((value, i) => (high[i] = Math.max(high[i], value)));
    }
    return low[0] <= high[0] ? { low, high } : null;
  }

  private change(look: (node: Node, index: number) => Partial<Look>): void {
    this.nodes.forEach((node, index) => {
      const next = { ...this.looks[index], ...look(node, index) };
      const now = this.looks[index];
      if (next.isGlass === now.isGlass && next.isTouching === now.isTouching) return;
      this.looks[index] = next;
      for (const mesh of this.meshes[index]) {
        mesh.material = this.material(mesh.userData["material"] as number, mesh.geometry, next);
        // Glass is drawn after everything else, farther objects first.
        mesh.renderOrder = next.isGlass ? 1 : 0;
      }
    });
  }

  private material(
    index: number,
    geometry: BufferGeometry,
    { isLink, isTouching, isGlass }: Look,
  ): MeshStandardMaterial {
    const vertexColors = geometry.hasAttribute("color");
    const key = `${index} ${vertexColors} ${isTouching && isLink} ${isTouching} ${isGlass}`;
    let found = this.known.get(key);
    if (!found) {
      const { colour, opacity, metallic, roughness } = this.materials[index];
      const seen = opacity * (isGlass ? GLASS_OPACITY : this.opacity);
      found = new MeshStandardMaterial({
        vertexColors,
        // The scene has little for a metal to reflect.
        metalness: metallic * 0.5,
        roughness,
        opacity: seen,
        transparent: seen < 1,
        depthWrite: !isGlass,
        // Faces in files may have the wrong orientation; glass shows only front faces.
        side: isGlass || this.opacity < 1 ? FrontSide : DoubleSide,
        polygonOffset: true,
        polygonOffsetFactor: this.opacity < 1 ? -1 : 1,
        polygonOffsetUnits: this.opacity < 1 ? -1 : 1,
      });
      found.color.setRGB(...colour, "srgb");
      if (isTouching) {
        found.color.lerp(found.color.clone().setHex(CONTACT), isLink ? LINK_TINT : BODY_TINT);
        found.emissive.setHex(CONTACT);
        found.emissiveIntensity = isLink ? 0.25 : 0;
      }
      this.known.set(key, found);
    }
    return found;
  }

  private edge(geometry: BufferGeometry): LineSegments {
    const lines = new LineSegments(new EdgesGeometry(geometry, EDGE_DEG), this.edgeMaterial);
    lines.matrixAutoUpdate = false;
    lines.matrix = new Matrix4();
    this.group.add(lines);
    return lines;
  }
}
