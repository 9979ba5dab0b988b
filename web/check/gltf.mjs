// Checks that the Khronos validator accepts each .glb file, that three.js loads it, and that the gripper ends at the
// selected grasp.
//
// node check/gltf.mjs FILE.glb…      exit 0: all pass; 1: faults, with reasons
import { readFileSync } from 'node:fs';
import { AnimationMixer, Quaternion, Vector3 } from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { validateBytes } from 'gltf-validator';

// Tolerances of the exact criterion, 1 mm and 1°, plus the error of single precision.
const ARRIVED_M = 1.01e-3;
const ARRIVED_RAD = (1.01 * Math.PI) / 180;

// Three.js expects these browser globals when it loads; no file here has a texture.
globalThis.self ??= globalThis;

const files = process.argv.slice(2);
if (files.length === 0) {
  console.error('name the .glb files to check');
  process.exit(2);
}
let faults = 0;
for (const file of files) {
  const bytes = new Uint8Array(readFileSync(file));
  const reasons = [...(await invalid(bytes)), ...(await notShown(bytes))];
  console.log(`${file}: ${bytes.length} bytes, ${reasons.length === 0 ? 'valid' : reasons.join('; ')}`);
  faults += reasons.length;
}
process.exit(faults === 0 ? 0 : 1);

/** The validator's complaints about the file, including warnings. */
async function invalid(bytes) {
  const report = await validateBytes(bytes, { maxIssues: 20 });
  return report.issues.messages
    .filter((message) => message.severity <= 1)
    .map((message) => `${message.code} at ${message.pointer}: ${message.message}`);
}

/** Faults in the file that a viewer would see. */
async function notShown(bytes) {
  const gltf = await new GLTFLoader().parseAsync(bytes.buffer, '');
  let taken = null;
  let meshes = 0;
  gltf.scene.traverse((object) => {
    meshes += object.isMesh ? 1 : 0;
    if (object.isMesh && object.material.name === 'grasp, taken') taken = object;
  });
  if (meshes === 0) return ['nothing to see'];
  if (gltf.animations.length === 0) return taken ? ['a grasp is taken but nothing moves'] : [];
  const mixer = new AnimationMixer(gltf.scene);
  const action = mixer.clipAction(gltf.animations[0]);
  action.clampWhenFinished = true;
  action.setLoop(2200, 1); // LoopOnce
  action.play();
  mixer.setTime(gltf.animations[0].duration);
  gltf.scene.updateMatrixWorld(true);
  const tip = gltf.scene.getObjectByName('panda_grasptarget');
  if (!tip || !taken) return [];
  const away = tip.getWorldPosition(new Vector3()).distanceTo(taken.getWorldPosition(new Vector3()));
  const grasp = taken.getWorldQuaternion(new Quaternion());
  const twin = grasp.clone().multiply(new Quaternion(0, 0, 1, 0));
  const own = tip.getWorldQuaternion(new Quaternion());
  const turned = Math.min(own.angleTo(grasp), own.angleTo(twin));
  if (away < ARRIVED_M && turned < ARRIVED_RAD) return [];
  return [`the gripper ends ${away} m and ${turned} rad from the grasp that was taken`];
}
