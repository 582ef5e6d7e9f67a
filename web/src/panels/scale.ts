/** The next of 1, 2, 5 times a power of ten. */
export function niceAtLeast(value: number): number {
  const power = 10 ** Math.floor(Math.log10(value));
  for (const factor of [1, 2, 5, 10])
    if (factor * power >= value * 0.999) return Number((factor * power).toPrecision(2));
  return value;
}
