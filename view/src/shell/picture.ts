/** A picture of all canvases in a part of the page, in their places; undefined if there are no canvases. */
export async function pictureOf(selector: string): Promise<Blob | undefined> {
  const part = document.querySelector(selector);
  const canvases = [...(part?.querySelectorAll('canvas') ?? [])].filter((canvas) => canvas.width > 0);
  if (part === null || canvases.length === 0) return undefined;
  const scale = devicePixelRatio;
  const boxes = canvases.map((canvas) => canvas.getBoundingClientRect());
  const left = Math.min(...boxes.map((box) => box.left));
  const top = Math.min(...boxes.map((box) => box.top));
  const picture = document.createElement('canvas');
  picture.width = Math.ceil((Math.max(...boxes.map((box) => box.right)) - left) * scale);
  picture.height = Math.ceil((Math.max(...boxes.map((box) => box.bottom)) - top) * scale);
  const context = picture.getContext('2d')!;
  context.fillStyle = getComputedStyle(document.documentElement).getPropertyValue('--page');
  context.fillRect(0, 0, picture.width, picture.height);
  canvases.forEach((canvas, i) => {
    const box = boxes[i]!;
    context.drawImage(canvas, (box.left - left) * scale, (box.top - top) * scale, box.width * scale, box.height * scale);
  });
  return new Promise((resolve) => { picture.toBlob((blob) => resolve(blob ?? undefined), 'image/png'); });
}
