// @ts-check
// Light, sky and floor, as in the images that `tatu look` renders: a directional lamp, ambient light from the sky and
// the ground, a weak light at the camera, and haze towards the horizon. The values are those of
// hosts/render/src/light.rs.

import * as THREE from "three";

/** Unit vector towards the lamp, in the world frame. */
export const LAMP = new THREE.Vector3(0.3, -0.6, 1).normalize();
const dark = matchMedia("(prefers-color-scheme: dark)");
/** Colors of the sky at the horizon and the zenith, linear RGB. They depend on the theme. */
const sky = { tatuHorizon: { value: new THREE.Color() }, tatuZenith: { value: new THREE.Color() } };
/** Height of the floor for a scene without one, m. Grid lines appear on horizontal surfaces at this height and at 0. */
const floorHeight = { value: 0 };
/**
 * Ratio of the tangent of half the camera's field of view to that of half the usual one. It scales the haze in parallel
 * projection.
 */
export const zoom = { value: 1 };

/** Sets the colors of the sky for the current theme. */
function updateSky() {
  const [horizon, zenith] = dark.matches ? [[0.035, 0.043, 0.055], [0.01, 0.014, 0.02]] : [[0.8, 0.86, 0.92], [0.3, 0.47, 0.72]];
  sky.tatuHorizon.value.fromArray(horizon ?? []);
  sky.tatuZenith.value.fromArray(zenith ?? []);
}
updateSky();

/**
 * Calls `f` after the theme has changed between light and dark.
 * @param {() => void} f
 */
export function onThemeChange(f) {
  dark.addEventListener("change", () => {
    updateSky();
    f();
  });
}

const VERTEX = `
vec4 tatuAt = vec4(transformed, 1.0);
#ifdef USE_INSTANCING
  tatuAt = instanceMatrix * tatuAt;
#endif
vTatuAt = (modelMatrix * tatuAt).xyz;
`;

/** Returns a vector as a GLSL expression. @param {THREE.Vector3} v */
const vec3 = (v) => `vec3(${v.toArray().map((x) => x.toFixed(9)).join(", ")})`;

const FRAGMENT_FUNCTIONS = `
varying vec3 vTatuAt;
uniform vec3 tatuHorizon;
uniform float tatuFloor, tatuZoom;

// Returns how much grid lines darken a point. Lines narrower than a pixel become fainter, and lines that are too close
// together fade out.
float tatuLines(vec2 p, vec2 reach, float spacing, float width, float strength) {
  vec2 off = abs(p - round(p / spacing) * spacing);
  vec2 covered = max(min(off + reach / 2.0, vec2(width / 2.0)) - max(off - reach / 2.0, vec2(-width / 2.0)), 0.0) / reach;
  vec2 thin = max(1.0 - off / reach, 0.0) * sqrt(width / reach);
  vec2 seen = min(mix(covered, thin, step(vec2(width), reach)), 1.0);
  vec2 fade = clamp(1.0 - 5.0 * reach / spacing, 0.0, 1.0);
  return strength * max(seen.x * fade.x, seen.y * fade.y);
}

vec3 tatuLight(vec3 color, vec3 n, vec3 eye, float lamp, float far) {
  float gloss = 0.12;
  #ifndef TATU_INSTANCED
  vec2 reach = max(abs(dFdx(vTatuAt.xy)) + abs(dFdy(vTatuAt.xy)), vec2(1e-6));
  if (n.z > 0.999 && (abs(vTatuAt.z) < 1e-3 || abs(vTatuAt.z - tatuFloor) < 1e-4)) {
    gloss = 0.0;
    color *= 1.0 - max(tatuLines(vTatuAt.xy, reach, 1.0, 0.012, 0.34), tatuLines(vTatuAt.xy, reach, 0.1, 0.004, 0.14));
  }
  #endif
  vec3 to = ${vec3(LAMP)};
  vec3 above = vec3(0.40, 0.43, 0.48);
  float facing = max(dot(n, eye), 0.0);
  vec3 light = mix(vec3(0.30, 0.29, 0.28), above, 0.5 + 0.5 * n.z) + 0.10 * facing;
  light += vec3(0.80, 0.77, 0.71) * max(dot(n, to), 0.0) * lamp;
  float mirrored = gloss * pow(max(dot(n, normalize(to + eye)), 0.0), 40.0) * lamp;
  vec3 rim = above * pow(1.0 - facing, 4.0) * gloss * 0.5;
  vec3 seen = color * light + mirrored + rim;
  // Bright light is compressed, so that white surfaces that face the lamp keep their shading.
  float brightest = max(max(seen.r, seen.g), seen.b);
  if (brightest > 0.6) seen *= (1.0 - 0.4 * exp((0.6 - brightest) / 0.4)) / brightest;
  float share = tatuZoom * far / (60.0 + 8.0 * tatuZoom * abs(cameraPosition.z));
  return mix(seen, tatuHorizon, 1.0 - exp(-share * share));
}
`;

const FRAGMENT_LIGHT = `
vec3 tatuTo = cameraPosition - vTatuAt;
float tatuFar = length(tatuTo);
vec3 tatuEye = tatuTo / max(tatuFar, 1e-6);
vec3 tatuNormal = inverseTransformDirection(normal, viewMatrix);
vec3 outgoingLight = tatuLight(diffuseColor.rgb, tatuNormal, tatuEye, getShadowMask(), tatuFar);
`;

/**
 * Inserts the light model into the shader of a material.
 * @param {{ vertexShader: string, fragmentShader: string, uniforms: { [name: string]: { value: unknown } } }} shader
 */
function compile(shader) {
  Object.assign(shader.uniforms, sky, { tatuFloor: floorHeight, tatuZoom: zoom });
  shader.vertexShader = `varying vec3 vTatuAt;\n${shader.vertexShader}`.replace("#include <project_vertex>", `#include <project_vertex>\n${VERTEX}`);
  const lightSum = "vec3 outgoingLight = reflectedLight.directDiffuse + reflectedLight.indirectDiffuse + totalEmissiveRadiance;";
  shader.fragmentShader = shader.fragmentShader
    .replace("void main() {", `#include <shadowmask_pars_fragment>\n${FRAGMENT_FUNCTIONS}\nvoid main() {`)
    .replace(/#include <lights_(lambert_fragment|fragment_begin|fragment_maps|fragment_end)>/g, "")
    .replace(lightSum, FRAGMENT_LIGHT);
}

/**
 * Returns a material for objects of the scene. If `isInstanced` is set, as for large scenes, the material omits grid
 * lines.
 * @param {THREE.MeshLambertMaterialParameters} parameters
 */
export function sceneMaterial(parameters, isInstanced = false) {
  const material = new THREE.MeshLambertMaterial(parameters);
  if (isInstanced) material.defines = { TATU_INSTANCED: "" };
  material.onBeforeCompile = compile;
  return material;
}

/**
 * Returns the parameters of a material with an opacity. A translucent material does not hide what is drawn after it.
 * The back of a closed form is omitted, so that the form as a whole has this opacity.
 * @param {number | undefined} opacity
 * @param {boolean} closed whether the surface is that of a closed form
 * @returns {THREE.MeshLambertMaterialParameters}
 */
export function opacityParameters(opacity = 1, closed = false) {
  if (opacity >= 1) return { side: THREE.DoubleSide };
  return { side: closed ? THREE.FrontSide : THREE.DoubleSide, transparent: true, opacity, depthWrite: false };
}

/** The sky, which is drawn behind all other objects. */
export const dome = new THREE.Mesh(
  new THREE.BoxGeometry(2, 2, 2),
  new THREE.ShaderMaterial({
    uniforms: sky,
    vertexShader: `
      varying vec3 vTo;
      void main() {
        vTo = (modelMatrix * vec4(position, 0.0)).xyz;
        vec4 at = projectionMatrix * mat4(mat3(viewMatrix)) * vec4(position, 1.0);
        gl_Position = at.xyww;
      }`,
    fragmentShader: `
      varying vec3 vTo;
      uniform vec3 tatuHorizon, tatuZenith;
      void main() {
        float height = max(normalize(vTo).z, 0.0);
        gl_FragColor = vec4(mix(tatuHorizon, tatuZenith, pow(min(height * 1.4, 1.0), 0.7)), 1.0);
        #include <colorspace_fragment>
      }`,
    side: THREE.BackSide,
    depthWrite: false,
    depthTest: false,
  }),
);
dome.frustumCulled = false;
dome.renderOrder = -1;

/** Half the side length of the square that represents an infinite plane, m. Its edge is hidden by the haze. */
const REACH = 2048;

/**
 * Creates the geometry of an infinite plane. Its triangles are small near the origin, where objects are, because
 * rounding errors of depths in a large triangle would make thin objects on it flicker.
 */
export function infinitePlane() {
  const side = [0];
  for (let x = 1; x <= REACH; x *= 2) side.push(x, -x);
  side.sort((a, b) => a - b);
  const n = side.length;
  const index = [];
  for (let i = 0; i + 1 < n; i++) {
    for (let k = 0; k + 1 < n; k++) {
      const at = i * n + k;
      index.push(at, at + n, at + 1, at + 1, at + n, at + n + 1);
    }
  }
  const geometry = new THREE.BufferGeometry();
  const points = side.flatMap((x) => side.flatMap((y) => [x, y, 0]));
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(points, 3));
  geometry.setAttribute("normal", new THREE.Float32BufferAttribute(points.map((_, i) => (i % 3 === 2 ? 1 : 0)), 3));
  geometry.setIndex(index);
  // Other modules recognize planes by this type.
  return Object.assign(geometry, { type: "PlaneGeometry" });
}

/** The floor that is drawn if the scene does not have one. */
export const floor = new THREE.Mesh(infinitePlane(), sceneMaterial({ color: new THREE.Color(0.42, 0.42, 0.42) }));
floor.receiveShadow = true;

/**
 * Sets the height and visibility of the floor for a scene without one.
 * @param {number} height m
 * @param {boolean} shown
 */
export function placeFloor(height, shown) {
  floor.position.z = floorHeight.value = height;
  floor.visible = shown;
}
