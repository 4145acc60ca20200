// The keys of the page in one list, which the help shows. A key of a part works while the focus is
// in it: in an element with data-keys="PART".

export type KeyPart = 'page' | 'waveform' | 'plots' | 'table';

export interface Key {
  /** As KeyboardEvent.key, with `Shift+`, `Ctrl+` or `Alt+` if these are held. */
  keys: string[];
  help: string;
  run: () => void;
}

const parts = new Map<KeyPart, Key[]>();

/** Adds keys to a part. The same keys of a part replace the earlier ones. */
export function defineKeys(part: KeyPart, keys: Key[]): void {
  const others = (parts.get(part) ?? []).filter((old) => !keys.some((key) => key.help === old.help));
  parts.set(part, [...others, ...keys]);
}

/** All keys, by part, as the help shows them. */
export function allKeys(): [KeyPart, Key[]][] {
  return [...parts];
}

// Letters that Shift makes have their own name already.
function nameOf(event: KeyboardEvent): string {
  const printed = event.key.length === 1;
  const shift = event.shiftKey && !printed ? 'Shift+' : '';
  const control = event.ctrlKey || event.metaKey ? 'Ctrl+' : '';
  return `${control}${event.altKey ? 'Alt+' : ''}${shift}${event.key}`;
}

function isTyping(target: EventTarget | null): boolean {
  return target instanceof HTMLElement
    && (target.isContentEditable || /^(INPUT|TEXTAREA|SELECT)$/.test(target.tagName));
}

// Keys that a button or a tab in focus has for itself.
function isForControl(event: KeyboardEvent): boolean {
  const target = event.target as HTMLElement | null;
  if (/^(Enter| )$/.test(event.key)) return target?.closest('button, a, summary, [role=tab]') != null;
  return event.key.startsWith('Arrow')
    && target?.closest('[role=tab], [role=separator], [role=menu]') != null;
}

function handle(event: KeyboardEvent): void {
  if (event.defaultPrevented || isTyping(event.target) || isForControl(event)) return;
  const target = event.target as Element | null;
  if (target?.closest('dialog') != null) return;
  const part = target?.closest('[data-keys]')?.getAttribute('data-keys') as KeyPart | null | undefined;
  const name = nameOf(event);
  const own = part == null ? [] : parts.get(part) ?? [];
  const found = [...own, ...(parts.get('page') ?? [])].find((key) => key.keys.includes(name));
  if (found === undefined) return;
  event.preventDefault();
  found.run();
}

/** Begins to listen, once. */
export function listenToKeys(): void {
  document.addEventListener('keydown', handle);
}
