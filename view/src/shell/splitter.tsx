// A bar between two parts of the page, moved by pointer or arrows. It sets a share in percent.
import type { Signal } from '@preact/signals';

interface Props {
  share: Signal<number>;
  direction: 'row' | 'column';
  label: string;
}

const least = 15;
const most = 85;

export function Splitter({ share, direction, label }: Props) {
  const set = (value: number) => { share.value = Math.max(least, Math.min(most, value)); };
  const onMove = (event: PointerEvent) => {
    const bar = event.currentTarget as HTMLElement;
    if (!bar.hasPointerCapture(event.pointerId)) return;
    const around = bar.parentElement!.getBoundingClientRect();
    set(direction === 'row'
      ? ((event.clientY - around.top) / around.height) * 100
      : ((event.clientX - around.left) / around.width) * 100);
  };
  const onKey = (event: KeyboardEvent) => {
    const step = { ArrowUp: -2, ArrowLeft: -2, ArrowDown: 2, ArrowRight: 2 }[event.key];
    if (step === undefined) return;
    event.preventDefault();
    set(share.value + step);
  };
  return (
    <div class={`splitter splitter-${direction}`} role="separator" tabIndex={0} aria-label={label}
      aria-orientation={direction === 'row' ? 'horizontal' : 'vertical'}
      aria-valuenow={Math.round(share.value)} aria-valuemin={least} aria-valuemax={most}
      onPointerDown={(event) => event.currentTarget.setPointerCapture(event.pointerId)}
      onPointerMove={onMove} onKeyDown={onKey} />
  );
}
