// The search field: Enter goes to the next row that matches, Shift+Enter to the one before.
import * as state from '../state';
import { suggestions } from '../core/condition';
import { defineKeys } from './keys';
import { found, searchedCondition, searchOn } from './search';

function focusSearch(): void {
  const field = document.querySelector<HTMLInputElement>('#search');
  field?.focus();
  field?.select();
}

defineKeys('page', [
  { keys: ['/', 'Ctrl+f'], help: 'Search', run: focusSearch },
  { keys: ['n', 'F3'], help: 'Next row that matches', run: () => void searchOn(1) },
  { keys: ['N', 'Shift+F3'], help: 'Previous row that matches', run: () => void searchOn(-1) },
  { keys: ['e'], help: 'Next row with an error', run: () => void searchOn(1, 'error') },
  { keys: ['E'], help: 'Previous row with an error', run: () => void searchOn(-1, 'error') },
]);

function onKey(event: KeyboardEvent): void {
  if (event.key === 'Enter') {
    event.preventDefault();
    state.search.value = (event.currentTarget as HTMLInputElement).value;
    void searchOn(event.shiftKey ? -1 : 1);
  }
  if (event.key === 'Escape') document.getElementById('table')?.focus();
}

function filterBySearch(): void {
  const condition = searchedCondition();
  state.filter.value = state.filter.value === condition ? '' : condition;
}

export function SearchField() {
  const { count, error } = found.value;
  const condition = searchedCondition();
  return (
    <div class="search" role="search">
      <input id="search" type="search" aria-label="Search" placeholder="Search: next crc, nW=0, position > 1000" list="conditions"
        value={state.search.value} spellcheck={false} autocomplete="off" aria-invalid={error !== ''} aria-describedby="search-result"
        onInput={(event) => { state.search.value = event.currentTarget.value; }} onKeyDown={onKey} />
      <datalist id="conditions">{suggestions.map((text) => <option key={text} value={text} />)}</datalist>
      <button type="button" class="icon" aria-label="Previous match" disabled={condition === ''} onClick={() => void searchOn(-1)}>↑</button>
      <button type="button" class="icon" aria-label="Next match" disabled={condition === ''} onClick={() => void searchOn(1)}>↓</button>
      <button type="button" title="Show only rows that match" disabled={condition === ''}
        aria-pressed={condition !== '' && state.filter.value === condition} onClick={filterBySearch}>Filter</button>
      <span id="search-result" class={error === '' ? 'result' : 'result wrong'} aria-live="polite">
        {error !== '' ? error : count === undefined ? '' : `${count} row${count === 1 ? '' : 's'}`}
      </span>
    </div>
  );
}
