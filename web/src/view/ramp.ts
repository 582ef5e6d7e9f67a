/**
 * The colours of a quantity from its least to its largest: perceptually even, and told apart by those who see no red.
 */

const kStops: [number, number, number][] = [
  [48, 18, 92],
  [58, 76, 146],
  [36, 128, 150],
  [44, 172, 132],
  [132, 206, 80],
  [248, 226, 60],
];

/** 256 x rgba. */
export const kRamp = makeRamp(kStops);

function makeRamp(stops: [number, number, number][]): Uint8Array<ArrayBuffer> {
  const ramp = new Uint8Array(4 * 256);
  for (let i = 0; i < 256; i++) {
    const place = (i / 255) * (stops.length - 1);
    const from = Math.min(Math.floor(place), stops.length - 2);
    const share = place - from;
    for (let c = 0; c < 3; c++)
      ramp[4 * i + c] = Math.round(stops[from]![c]! * (1 - share) + stops[from + 1]![c]! * share);
    ramp[4 * i + 3] = 255;
  }
  return ramp;
}

/** Colours of things that are told apart by their number, 0 to 1. */
export const kPalette: [number, number, number][] = [
  [0.27, 0.51, 0.79],
  [0.9, 0.56, 0.21],
  [0.36, 0.67, 0.45],
  [0.79, 0.36, 0.38],
  [0.55, 0.44, 0.74],
  [0.6, 0.46, 0.34],
  [0.83, 0.51, 0.71],
  [0.42, 0.7, 0.74],
  [0.73, 0.7, 0.28],
  [0.5, 0.55, 0.6],
];

export function paletteColor(index: number): [number, number, number] {
  return kPalette[index % kPalette.length]!;
}
