// The keys, as they are defined.
import { signal } from '@preact/signals';
import { useEffect, useRef } from 'preact/hooks';
import { allKeys, type KeyPart } from './keys';

const isOpen = signal(false);

export function showHelp(): void {
  isOpen.value = true;
}

const names: Record<KeyPart, string> = {
  page: 'Everywhere',
  waveform: 'In the waveform',
  plots: 'In the plots',
  table: 'In the table',
};

export function Help() {
  const dialog = useRef<HTMLDialogElement>(null);
  useEffect(() => {
    if (isOpen.value && dialog.current?.open === false) dialog.current.showModal();
  }, [isOpen.value]);
  if (!isOpen.value) return null;
  return (
    <dialog ref={dialog} class="help" aria-labelledby="help-title" onClose={() => { isOpen.value = false; }}>
      <form method="dialog" class="dialog-head">
        <h2 id="help-title">Keys</h2>
        <button type="submit">Close</button>
      </form>
      <div class="help-parts">
        {allKeys().map(([part, keys]) => (
          <section key={part}>
            <h3>{names[part]}</h3>
            <dl>
              {keys.map((key) => (
                <div key={key.help}>
                  <dt>{key.keys.map((name) => <kbd key={name}>{printed(name)}</kbd>)}</dt>
                  <dd>{key.help}</dd>
                </div>
              ))}
            </dl>
          </section>
        ))}
      </div>
      <h3>Search</h3>
      <p>
        A status or a comparison of a column: <code>next crc</code>, <code>previous nW=0</code>,{' '}
        <code>position &gt; 1000 and not ok</code>, <code>ack &gt; 10us</code>, <code>error</code>. Join with{' '}
        <code>and</code>, <code>or</code>, <code>not</code> and brackets.
      </p>
      <p>Nothing of a capture leaves this machine: the page sends no request to any server.</p>
    </dialog>
  );
}

function printed(name: string): string {
  const names: Record<string, string> = { ArrowUp: '↑', ArrowDown: '↓', ArrowLeft: '←', ArrowRight: '→', ' ': 'Space' };
  return name.split(/\+(?=.)/).map((part) => names[part] ?? part).join(' ');
}
