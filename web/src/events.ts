/** A list of listeners of one kind of event. What a listener throws is reported and keeps no other from hearing. */
export class Signal<Arguments extends unknown[]> {
  readonly #listeners = new Set<(...args: Arguments) => void>();

  /** Returns what takes the listener away again. */
  on(listener: (...args: Arguments) => void): () => void {
    this.#listeners.add(listener);
    return () => this.#listeners.delete(listener);
  }

  emit(...args: Arguments): void {
    for (const listener of this.#listeners) {
      try {
        listener(...args);
      } catch (error) {
        console.error(error);
      }
    }
  }
}
