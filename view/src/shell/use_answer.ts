// The answer of the worker for a part of the page.
import { useEffect, useState } from 'preact/hooks';
import { Superseded } from '../core/client';
import { core } from '../core/core';
import type { Answer, Ask, RequestName } from '../core/protocol';
import { messageOf } from '../core/texts';

interface Found<K extends RequestName> {
  /** Undefined if the request has failed. */
  answer: Answer<K> | undefined;
  error: string;
}

/**
 * Asks when `parts` have changed and not changed again for `pause` milliseconds, unless there is nothing
 * to `ask`. Undefined before the first answer; then the newest answer.
 */
export function useAnswer<K extends RequestName>(
  name: K, ask: Ask<K> | undefined, parts: unknown[], pause = 0,
): Found<K> | undefined {
  const [found, setFound] = useState<Found<K>>();
  useEffect(() => {
    if (ask === undefined) {
      setFound(undefined);
      return undefined;
    }
    const send = () => core().ask(name, ask, { lane: `use.${name}` }).then(
      (answer) => setFound({ answer, error: '' }),
      (error: unknown) => {
        if (!(error instanceof Superseded)) setFound({ answer: undefined, error: messageOf(error) });
      },
    );
    const timer = pause === 0 ? void send() : setTimeout(send, pause);
    return () => clearTimeout(timer);
  }, [...parts, ask === undefined]);
  return found;
}
