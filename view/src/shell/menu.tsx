// A button that opens a list of actions.
import { useRef } from 'preact/hooks';

export interface Action {
  name: string;
  about?: string;
  run: () => void;
}

export function Menu({ label, actions }: { label: string; actions: readonly Action[] }) {
  const box = useRef<HTMLDetailsElement>(null);
  const close = (focus: boolean) => {
    if (box.current === null) return;
    box.current.open = false;
    if (focus) box.current.querySelector('summary')?.focus();
  };
  const onKey = (event: KeyboardEvent) => {
    if (event.key === 'Escape') close(true);
    const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (step === undefined || box.current === null || !box.current.open) return;
    event.preventDefault();
    const buttons = [...box.current.querySelectorAll('button')];
    const at = buttons.indexOf(document.activeElement as HTMLButtonElement);
    buttons[(at + step + buttons.length) % buttons.length]?.focus();
  };
  const onLeave = (event: FocusEvent) => {
    if (!box.current?.contains(event.relatedTarget as Node | null)) close(false);
  };
  return (
    <details class="menu" ref={box} onKeyDown={onKey} onFocusOut={onLeave}>
      <summary>{label}</summary>
      <ul>
        {actions.map(({ name, about, run }) => (
          <li key={name}>
            <button type="button" onClick={() => { close(true); run(); }}>
              {name}{about !== undefined && <small>{about}</small>}
            </button>
          </li>
        ))}
      </ul>
    </details>
  );
}
