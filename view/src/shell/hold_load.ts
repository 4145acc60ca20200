// The load event of a page that contains its capture comes when the capture is shown: programs that print a
// page or take a picture of it wait for its load event.
import { effect } from '@preact/signals';
import { progress } from '../state';

// The load event is held for at most this time, in milliseconds.
const most = 60_000;
const framesAtRest = 4;

/** Holds the load event until the capture is shown. To be called while the page is being parsed. */
export function holdLoad(): void {
  // A document that is open keeps the page around it from being loaded.
  const frame = document.createElement('iframe');
  frame.hidden = true;
  document.body.append(frame);
  const inner = frame.contentDocument;
  inner?.open();
  const release = () => {
    inner?.close();
    frame.remove();
  };
  const limit = setTimeout(release, most);
  const stop = effect(() => {
    if (!['ended', 'failed'].includes(progress.value.state)) return;
    queueMicrotask(() => stop());
    whenAtRest(() => {
      clearTimeout(limit);
      release();
    });
  });
}

// Calls `then` when no request to the core is open and its answers have been drawn.
function whenAtRest(then: () => void): void {
  let frames = 0;
  const look = () => {
    frames = document.documentElement.hasAttribute('data-waiting') ? 0 : frames + 1;
    if (frames > framesAtRest) then();
    else requestAnimationFrame(look);
  };
  look();
}
