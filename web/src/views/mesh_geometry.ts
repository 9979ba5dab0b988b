import { BufferAttribute, BufferGeometry, Matrix4, Quaternion, Vector3 } from "three";
import type { Mesh, PageData, Pose } from "../data/page_data.ts";
import { floats32, unsigned32 } from "../data/numbers.ts";

/** Section of a mesh with one material. */
export interface Piece {
  material: number;
  geometry: BufferGeometry;
}

/** The meshes of a page, each decoded once. */
export class MeshGeometries {
  private readonly meshes: Mesh[];
  private readonly known = new Map<number, Piece[]>();

  constructor(data: PageData) {
    this.meshes = data.meshes;
  }

  of(mesh: number): Piece[] {
    let pieces = this.known.get(mesh);
    if (!pieces) {
      pieces = this.meshes[mesh].pieces.map((piece) => {
        const geometry = new BufferGeometry();
        geometry.setAttribute("position", new BufferAttribute(floats32(piece.positions), 3));
        geometry.setIndex(new BufferAttribute(unsigned32(piece.triangles), 1));
        const normals = floats32(piece.normals);
        if (normals.length > 0) geometry.setAttribute("normal", new BufferAttribute(normals, 3));
        else geometry.computeVertexNormals();
        if (piece.colours) geometry.setAttribute("color", new BufferAttribute(floats32(piece.colours), 3));
        geometry.computeBoundingBox();
        return { material: piece.material, geometry };
      });
      this.known.set(mesh, pieces);
    }
    return pieces;
  }
}

/** Writes a pose into a matrix. */
export function setMatrix(matrix: Matrix4, pose: Pose): Matrix4 {
  position.set(pose[0], pose[1], pose[2]);
  turn.set(pose[3], pose[4], pose[5], pose[6]);
  return matrix.compose(position, turn, UNIT);
}

const position = new Vector3();
const turn = new Quaternion();
const UNIT = new Vector3(1, 1, 1);
