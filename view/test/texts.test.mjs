import assert from 'node:assert/strict';
import { test } from 'node:test';
import { load } from './typescript.mjs';

const { cellsOfCsv } = await load('core/texts.ts');

test('CellsOfCsv_EmptyAndQuotedOnes_AreAllThere', () => {
  assert.deepEqual(cellsOfCsv('a,b\n1,\n,2\n"x,""y""",3\n'), [['a', 'b'], ['1', ''], ['', '2'], ['x,"y"', '3']]);
});
