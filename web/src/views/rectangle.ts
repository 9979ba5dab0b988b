import {
  BufferGeometry,
  Float32BufferAttribute,
  Group,
  LineBasicMaterial,
  LineLoop,
  Mesh,
  MeshBasicMaterial,
  PlaneGeometry,
} from "three";

/** Distance above the support, in metres, so that both are visible. */
const LIFT_M = 0.003;

/** A translucent rectangle with an edge, centred at the origin in the xy plane. */
export function rectangle(width_m: number, depth_m: number, colour: number): Group {
  const group = new Group();
  const plane = new Mesh(
    new PlaneGeometry(width_m, depth_m),
    new MeshBasicMaterial({ color: colour, transparent: true, opacity: 0.08, depthWrite: false }),
  );
  plane.position.set(0, 0, LIFT_M);
  plane.renderOrder = -1;
  const [x, y, z] = [width_m / 2, depth_m / 2, LIFT_M];
  const corners = [-x, -y, z, x, -y, z, x, y, z, -x, y, z];
  const geometry = new BufferGeometry().setAttribute("position", new Float32BufferAttribute(corners, 3));
  group.add(plane, new LineLoop(geometry, new LineBasicMaterial({ color: colour, transparent: true, opacity: 0.7 })));
  return group;
}
