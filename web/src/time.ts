/** Times of messages: nanoseconds as the wire has them (bigint), seconds in the page. */

/** Seconds of nanoseconds; keeps 0.1 ms even of a wall clock's time. */
export function seconds(nanoseconds: bigint): number {
  return Number(nanoseconds / 1000n) / 1e6;
}

/** "12.34 s" of small times (simulated ones), the time of day of a wall clock's. */
export function clockText(time: number): string {
  if (!Number.isFinite(time)) return "–";
  if (Math.abs(time) < 1e7) return `${time.toFixed(2)} s`;
  return new Date(time * 1000).toLocaleTimeString(undefined, { hour12: false });
}

/** "1:02.5" of a duration in seconds. */
export function durationText(duration: number): string {
  const whole = Math.max(0, duration);
  const minutes = Math.floor(whole / 60);
  return `${minutes}:${(whole - 60 * minutes).toFixed(1).padStart(4, "0")}`;
}
