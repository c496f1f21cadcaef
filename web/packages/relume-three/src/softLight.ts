import { Vector3 } from "three";

/** A light at infinity, in world space; colour 1 is the light of the photographs. */
export interface ReflectanceLight {
  direction: [number, number, number];
  color: [number, number, number];
  /** The angle from the middle of the light to its rim, in radians: 0, which is also the default, is a point. */
  softness?: number;
}

export const MOST_LIGHTS = 4;
/**
 * Directions of a soft light, one in the middle and then six for each ring further out: of one among several, or where each takes
 * long; and of one alone.
 */
const FEW = [1, 6], MANY = [1, 6, 12];
/** Room for four soft lights, or for one alone and three others. */
export const MOST_DIRECTIONS = 28;

/** Each light as the directions that it comes from; few of them where each takes long. */
export function directionsOf(lights: ReflectanceLight[], takeLong = false): { direction: Vector3; color: Vector3 }[] {
  const first = lights.slice(0, MOST_LIGHTS), isSoft = ({ softness }: ReflectanceLight): boolean => softness !== undefined && softness > 0;
  const rings = first.filter(isSoft).length === 1 && !takeLong ? MANY : FEW;
  return first.flatMap((light) => {
    const axis = new Vector3(...light.direction).normalize(), color = new Vector3(...light.color);
    if (!isSoft(light)) return [{ direction: axis, color }];
    const directions = capOf(axis, light.softness ?? 0, rings);
    return directions.map((direction) => ({ direction, color: color.clone().divideScalar(directions.length) }));
  });
}

/** Directions of equal solid angles around an axis. */
function capOf(axis: Vector3, angle: number, rings: number[]): Vector3[] {
  const right = new Vector3(Math.abs(axis.x) < 0.7 ? 1 : 0, Math.abs(axis.x) < 0.7 ? 0 : 1, 0).cross(axis).normalize(), up = axis.clone().cross(right);
  const total = rings.reduce((sum, count) => sum + count, 0), out: Vector3[] = [];
  for (const count of rings) {
    // The middle of the ring's share of the cap.
    const height = 1 - ((out.length + (count > 1 ? count / 2 : 0)) / total) * (1 - Math.cos(angle)), across = Math.sqrt(1 - height * height);
    for (let i = 0; i < count; i++) {
      const azimuth = (2 * Math.PI * (i + 0.5)) / count;
      out.push(axis.clone().multiplyScalar(height).addScaledVector(right, across * Math.cos(azimuth)).addScaledVector(up, across * Math.sin(azimuth)));
    }
  }
  return out;
}
