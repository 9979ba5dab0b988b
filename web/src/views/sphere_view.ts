import { Group, IcosahedronGeometry, InstancedMesh, Matrix4, MeshLambertMaterial } from "three";
import { setMatrix } from "./mesh_geometry.ts";
import { floats32 } from "../data/numbers.ts";
import type { PageData, Pose } from "../data/page_data.ts";

const SPHERES = 0x12a48b;
const OPACITY = 0.32;

/** Fine enough for a link's sphere to appear round. */
const DETAIL = 2;

/** The outer spheres of the links, with which a collision check begins: one draw call. */
export class SphereView {
  readonly group = new Group();
  readonly count: number;
  private readonly linkOf: number[] = [];
  private readonly inLink: Matrix4[] = [];
  private readonly mesh: InstancedMesh;
  private readonly link = new Matrix4();
  private readonly sphere = new Matrix4();

  constructor(data: PageData) {
    data.link_spheres.forEach((text, link) => {
      const rows = floats32(text);
      for (let at = 0; at + 3 < rows.length; at += 4) {
        const [x, y, z, radius] = rows.subarray(at, at + 4);
        this.linkOf.push(link);
        this.inLink.push(new Matrix4().makeScale(radius, radius, radius).setPosition(x, y, z));
      }
    });
    this.count = this.linkOf.length;
    const material = new MeshLambertMaterial({
      color: SPHERES,
      transparent: true,
      opacity: OPACITY,
      depthWrite: false,
    });
    this.mesh = new InstancedMesh(new IcosahedronGeometry(1, DETAIL), material, this.count);
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = 3;
    this.group.add(this.mesh);
    this.group.visible = false;
  }

  pose(worldFromLinks: Pose[]): void {
    if (!this.group.visible) return;
    let shown = -1;
    this.linkOf.forEach((link, index) => {
      if (link !== shown) setMatrix(this.link, worldFromLinks[link]);
      shown = link;
      this.mesh.setMatrixAt(index, this.sphere.multiplyMatrices(this.link, this.inLink[index]));
    });
    this.mesh.instanceMatrix.needsUpdate = true;
  }
}
