/** The answer to the newest question; asked at most a few times a second. */
import type { Requests } from '../core/protocol';
import { core } from '../core/core';

const pause = 300;

export class Latest<K extends 'analyse.eye' | 'analyse.causes'> {
  answer: Requests[K]['answer'] | undefined;
  #wanted = '';
  #asked = '';
  #ask: Requests[K]['ask'] | undefined;
  #timer: ReturnType<typeof setTimeout> | undefined;

  constructor(
    private readonly name: K,
    private readonly lane: string,
    private readonly onAnswer: () => void,
  ) {}

  /** `key` says what the question depends on: the same is not asked twice. */
  want(key: string, ask: Requests[K]['ask']): void {
    this.#wanted = key;
    this.#ask = ask;
    if (key !== this.#asked) this.#timer ??= setTimeout(() => this.#send(), pause);
  }

  close(): void {
    clearTimeout(this.#timer);
    this.#ask = undefined;
  }

  #send(): void {
    this.#timer = undefined;
    if (this.#ask === undefined) return;
    const key = this.#wanted;
    this.#asked = key;
    core().ask(this.name, this.#ask, { lane: this.lane }).then(
      (answer) => {
        if (this.#ask === undefined) return;
        this.answer = answer;
        this.onAnswer();
      },
      () => undefined,
    );
  }
}
