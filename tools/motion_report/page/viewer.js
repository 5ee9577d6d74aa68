// Plays a clip: the source's skeleton and the character, or several motions of
// the character, side by side.

import * as THREE from "three";
import {OrbitControls} from "orbit_controls";
import {h} from "./elements.js";

const SOURCE_COLOUR = 0xd97706, BODY_COLOUR = 0x0f9488;
const GAP = 0.75;  // m, of each from the middle
const BESIDE = 1.1;  // m, between motions of a crowd

function unpack(base64, unit) {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  const view = new DataView(bytes.buffer);
  const numbers = new Float32Array(bytes.length / 2);
  for (let i = 0; i < numbers.length; ++i) numbers[i] = view.getInt16(2 * i, true) * unit;
  return numbers;
}

// A shape of body_shapes.h; MuJoCo's long axis is z, three.js's y.
function shapeMesh(shape, material) {
  const [a, b, c] = shape.size;
  const along = new THREE.Matrix4().makeRotationX(Math.PI / 2);
  let geometry;
  if (shape.type === "box") geometry = new THREE.BoxGeometry(2 * a, 2 * b, 2 * c);
  else if (shape.type === "capsule") {
    geometry = new THREE.CapsuleGeometry(a, 2 * b, 6, 14).applyMatrix4(along);
  } else if (shape.type === "cylinder") {
    geometry = new THREE.CylinderGeometry(a, a, 2 * b, 20).applyMatrix4(along);
  } else {
    geometry = new THREE.SphereGeometry(1, 20, 14);
    geometry.scale(a, shape.type === "sphere" ? a : b, shape.type === "sphere" ? a : c);
  }
  const mesh = new THREE.Mesh(geometry, material);
  mesh.position.fromArray(shape.position);
  const [w, x, y, z] = shape.rotation;
  mesh.quaternion.set(x, y, z, w);
  mesh.castShadow = true;
  return mesh;
}

// Gives up what the graphics card holds of a group.
function dispose(group) {
  group.traverse((object) => {
    if (object.geometry) object.geometry.dispose();
    if (object.material) object.material.dispose();
  });
}

class Character {
  constructor(bodies) {
    this.group = new THREE.Group();
    const material = new THREE.MeshStandardMaterial({color: BODY_COLOUR, roughness: 0.55});
    this.bodies = bodies.map((body) => {
      const group = new THREE.Group();
      group.add(...body.shapes.map((shape) => shapeMesh(shape, material)));
      this.group.add(group);
      return group;
    });
  }
  pose(clip, frame) {
    this.bodies.forEach((body, index) => {
      const row = frame * clip.bodies + index;
      body.position.fromArray(clip.position, 3 * row);
      const [w, x, y, z] = clip.rotation.subarray(4 * row, 4 * row + 4);
      body.quaternion.set(x, y, z, w).normalize();
    });
  }
}

class Skeleton {
  constructor(parents) {
    this.parents = parents;
    this.group = new THREE.Group();
    const material = new THREE.MeshStandardMaterial({color: SOURCE_COLOUR, roughness: 0.6});
    const bone = new THREE.CylinderGeometry(0.012, 0.02, 1, 8).translate(0, 0.5, 0);
    this.joints = new THREE.InstancedMesh(new THREE.SphereGeometry(0.026, 12, 8), material,
                                          parents.length);
    this.bones = new THREE.InstancedMesh(bone, material, parents.length);
    for (const mesh of [this.joints, this.bones]) {
      mesh.castShadow = true;
      mesh.frustumCulled = false;
      this.group.add(mesh);
    }
  }
  pose(clip, frame) {
    const up = new THREE.Vector3(0, 1, 0), matrix = new THREE.Matrix4();
    const at = (joint) => new THREE.Vector3().fromArray(
        clip.source, 3 * (frame * this.parents.length + joint));
    this.parents.forEach((parent, joint) => {
      const end = at(joint);
      this.joints.setMatrixAt(joint, matrix.makeTranslation(end));
      const start = parent < 0 ? end : at(parent);
      const along = end.clone().sub(start), length = along.length();
      const turn = new THREE.Quaternion();
      if (length > 1e-6) turn.setFromUnitVectors(up, along.divideScalar(length));
      this.bones.setMatrixAt(joint, matrix.compose(start, turn,
          length > 1e-6 ? new THREE.Vector3(1, length, 1) : new THREE.Vector3(0, 0, 0)));
    });
    this.joints.instanceMatrix.needsUpdate = true;
    this.bones.instanceMatrix.needsUpdate = true;
  }
}

// Squares of half a metre, to see speed and sliding by.
function checkTexture(dark) {
  const tile = h("canvas", {width: 64, height: 64});
  const context = tile.getContext("2d");
  context.fillStyle = dark ? "#1f2328" : "#eeece6";
  context.fillRect(0, 0, 64, 64);
  context.fillStyle = dark ? "#272c32" : "#e4e1d8";
  context.fillRect(0, 0, 32, 32);
  context.fillRect(32, 32, 32, 32);
  const texture = new THREE.CanvasTexture(tile);
  texture.wrapS = texture.wrapT = THREE.RepeatWrapping;
  texture.repeat.set(120, 120);
  texture.colorSpace = THREE.SRGBColorSpace;
  texture.magFilter = THREE.NearestFilter;
  texture.anisotropy = 8;
  return texture;
}

function makeScene(dark) {
  const scene = new THREE.Scene();
  scene.background = new THREE.Color(dark ? 0x1f2328 : 0xeeece6);
  scene.fog = new THREE.Fog(scene.background, 9, 26);
  scene.add(new THREE.HemisphereLight(0xffffff, dark ? 0x22262b : 0xb9b3a4, 1.5));
  const sun = new THREE.DirectionalLight(0xffffff, 2.2);
  sun.castShadow = true;
  sun.shadow.mapSize.set(1024, 1024);
  Object.assign(sun.shadow.camera, {left: -3, right: 3, top: 3, bottom: -3, far: 14});
  const floor = new THREE.Mesh(new THREE.PlaneGeometry(120, 120), new THREE.ShadowMaterial({
    opacity: 0.28}));
  floor.receiveShadow = true;
  const checks = new THREE.Mesh(new THREE.PlaneGeometry(120, 120),
      new THREE.MeshBasicMaterial({map: checkTexture(dark)}));
  checks.position.z = -0.004;
  scene.add(sun, sun.target, floor, checks);
  return {scene, sun};
}

function readClip(index) {
  const json = JSON.parse(document.getElementById(`trajectory-${index}`).textContent);
  return {...json, position: unpack(json.body_position, 1e-3),
    rotation: unpack(json.body_rotation, 1 / 32767),
    source: unpack(json.source_position, 1e-3)};
}

// Returns {element, show(clip)}; `bodies` as body_shapes.h makes them. A clip's
// `companions`, indices of trajectories, are played beside it, all as long as the
// longest of them.
export function makeViewer(bodies) {
  const canvas = h("canvas", {role: "img", "aria-label": "the clip, played"});
  const none = h("div", {class: "none", hidden: ""});
  const time = h("span", {}), title = h("b", {});
  const slider = h("input", {type: "range", min: 0, value: 0, "aria-label": "time"});
  const button = h("button", {class: "round", "aria-label": "play or pause"});
  const speed = h("select", {"aria-label": "speed"},
      ["0.25", "0.5", "1", "2"].map((s) => h("option", {value: s}, s + " x")));
  speed.value = "1";
  const overlay = h("input", {type: "checkbox"});
  const overlayLabel = h("label", {}, overlay, "on top of each other");
  const dot = (colour, text) => h("span", {}, h("i", {
    style: "background:#" + colour.toString(16).padStart(6, "0")}), text);
  const sourceKey = dot(SOURCE_COLOUR, "source"), key = h("div", {class: "key"}, sourceKey,
      dot(BODY_COLOUR, "character"));
  const element = h("div", {class: "panel viewer"}, canvas, none, key,
      h("div", {class: "controls"}, button, title, slider, time, speed, overlayLabel));
  const say = (text) => {
    none.textContent = text;
    none.hidden = !text;
    canvas.style.display = text ? "none" : "block";
    key.style.display = text ? "none" : "flex";
  };
  let renderer;
  try {
    renderer = new THREE.WebGLRenderer({canvas, antialias: true});
  } catch (error) {
    say("This browser has no WebGL, which the viewer draws with.");
    return {element, show: () => {}};
  }
  renderer.shadowMap.enabled = true;
  renderer.setPixelRatio(Math.min(2, devicePixelRatio));
  const {scene, sun} = makeScene(matchMedia("(prefers-color-scheme: dark)").matches);
  const camera = new THREE.PerspectiveCamera(38, 1, 0.05, 60);
  camera.up.set(0, 0, 1);
  const orbit = new OrbitControls(camera, canvas);
  orbit.maxPolarAngle = Math.PI / 2 - 0.02;
  orbit.enablePan = false;
  const character = new Character(bodies);
  scene.add(character.group);
  let crowd = [];  // {clip, character}: the companions
  let frames = 0;  // of the longest of all that is played
  let skeleton = null, clip = null, frame = 0, last = 0, side = new THREE.Vector3(1, 0, 0);
  let playing = !matchMedia("(prefers-reduced-motion: reduce)").matches;

  // What is shorter holds its last frame.
  const within = (of, at) => Math.min(at, of.frames - 1);
  const root = (at) => new THREE.Vector3(clip.position[3 * at * clip.bodies],
                                         clip.position[3 * at * clip.bodies + 1], 0.85);
  const draw = () => {
    const whole = Math.min(frames - 1, Math.floor(frame)), own = within(clip, whole);
    character.pose(clip, own);
    const gap = crowd.length ? -BESIDE * crowd.length / 2 :
        skeleton && !overlay.checked ? GAP : 0;
    character.group.position.copy(side).multiplyScalar(gap);
    if (skeleton) {
      skeleton.pose(clip, own);
      skeleton.group.position.copy(side).multiplyScalar(-gap);
    }
    crowd.forEach((other, index) => {
      other.character.pose(other.clip, within(other.clip, whole));
      other.character.group.position.copy(side).multiplyScalar(
          BESIDE * (index + 1 - crowd.length / 2));
    });
    const target = root(own), moved = target.clone().sub(orbit.target);
    orbit.target.copy(target);
    camera.position.add(moved);
    sun.target.position.copy(target);
    sun.position.copy(target).add(new THREE.Vector3(2, -3, 6));
    slider.value = whole;
    time.textContent = `${(whole / clip.fps).toFixed(2)} s${clip.cut ? " (beginning)" : ""}`;
    button.textContent = playing ? "❚❚" : "▶";
    orbit.update();
    renderer.render(scene, camera);
  };
  const resize = () => {
    const {clientWidth: width, clientHeight: height} = canvas;
    if (!width || !height) return;
    renderer.setSize(width, height, false);
    camera.aspect = width / height;
    camera.updateProjectionMatrix();
  };
  new ResizeObserver(() => { resize(); if (clip) draw(); }).observe(canvas);
  const step = (now) => {
    if (clip) {
      const seconds = Math.min(0.1, (now - last) / 1000);
      if (playing) frame = (frame + seconds * clip.fps * Number(speed.value)) % frames;
      draw();
    }
    last = now;
    requestAnimationFrame(step);
  };
  button.addEventListener("click", () => { playing = !playing; if (clip) draw(); });
  slider.addEventListener("input", () => { playing = false; frame = Number(slider.value); });
  requestAnimationFrame(step);

  // Where the body faces first, the camera stands to its right and before it.
  const place = () => {
    const facing = new THREE.Vector3(1, 0, 0).applyQuaternion(character.bodies[0].quaternion);
    facing.z = 0;
    if (facing.length() < 0.1) facing.set(1, 0, 0);
    facing.normalize();
    const right = new THREE.Vector3(facing.y, -facing.x, 0);
    const from = right.multiplyScalar(0.8).add(facing.clone().multiplyScalar(0.6));
    side.set(-from.y, from.x, 0);
    orbit.target.copy(root(0));
    camera.position.copy(root(0)).addScaledVector(from, 4.6 + 0.8 * crowd.length)
        .add(new THREE.Vector3(0, 0, 0.9));
  };
  const show = (of) => {
    title.textContent = of.name;
    if (skeleton) scene.remove(skeleton.group);
    crowd.forEach((other) => {
      scene.remove(other.character.group);
      dispose(other.character.group);
    });
    crowd = [];
    skeleton = clip = null;
    if (of.trajectory === undefined) {
      say(of.figures ? "This clip is not among those that the page can play; to see it: " +
          `sinew motion report LIB --clips "${of.name}"` : "Nothing to play: " + of.reason);
      return;
    }
    say("");
    clip = readClip(of.trajectory);
    if (clip.source_parents.length > 0) {
      skeleton = new Skeleton(clip.source_parents);
      scene.add(skeleton.group);
    }
    crowd = (of.companions || []).map((index) => ({
      clip: readClip(index), character: new Character(bodies)}));
    crowd.forEach((other) => scene.add(other.character.group));
    sourceKey.style.display = overlayLabel.style.display = skeleton ? "" : "none";
    frames = Math.max(clip.frames, ...crowd.map((other) => other.clip.frames));
    slider.max = frames - 1;
    frame = 0;
    resize();
    character.pose(clip, 0);
    place();
    draw();
  };
  return {element, show};
}
